//! `stress` finds planted faults, and finds none in built-in kinds and pipelines.

mod planted;

use afterimage_graph::check::NoFiles;
use afterimage_graph::node::NodeKind;
use afterimage_lab::stress::{StressOptions, StressReport, Target, kinds, registry, stress};
use afterimage_plan::Options;

use crate::support::gpu::gpu;
use crate::support::sweep;

/// Of the tenth that runs every day.
const SEED: u64 = 1;

/// A part of the cases, with the planner's switches as they are by default.
fn quick() -> StressOptions {
    StressOptions {
        case: None,
        size: None,
        defaults: false,
        quick: true,
        unsanitized: false,
        tenth: None,
        options: Options::default(),
    }
}

/// Every kind of the tables alone, through the chosen cases.
fn stressed(tables: &[&[NodeKind]], choice: &StressOptions) -> StressReport {
    let registry = registry(tables).expect("no two kinds share a name");
    let (targets, skipped) = kinds(&registry, tables);
    assert_eq!(skipped, Vec::<String>::new());
    assert!(targets.len() >= tables.iter().map(|table| table.len()).sum(), "some kinds cannot run alone");
    stress(&gpu(), &targets, choice, &())
}

fn reproduced(report: &StressReport) -> String {
    report.failures().map(|failed| format!("{}: {}\n{}\n", failed.case, failed.why, failed.command)).collect()
}

/// Default parameters, and a tenth of all plan variants, but for a whole sweep.
#[test]
fn built_in_kinds_and_the_plugin_have_no_faults() {
    let choice = StressOptions { defaults: !sweep::is_whole(), tenth: (!sweep::is_whole()).then_some(SEED), ..quick() };
    let report = stressed(&[afterimage_nodes::ALL, halftone::ALL], &choice);
    assert!(report.cases() > if sweep::is_whole() { 10_000 } else { 1_000 }, "only {} cases", report.cases());
    assert_eq!(report.failures().count(), 0, "{}", reproduced(&report));
}

#[test]
fn a_built_in_pipeline_has_no_faults() {
    let registry = registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let targets: Vec<Target> = ["lynx", "exposure"]
        .map(|name| {
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../pipelines/{name}.ron"));
            let text = std::fs::read_to_string(path).expect("a built-in pipeline");
            Target::pipeline(name, name, name, &text, &registry, &NoFiles).expect("a built-in pipeline")
        })
        .into();
    let choice = StressOptions { defaults: true, ..quick() };
    let report = stress(&gpu(), &targets, &choice, &());
    assert_eq!(report.failures().count(), 0, "{}", reproduced(&report));
    assert!(report.cases() > 100, "only {} cases", report.cases());
}

#[test]
fn every_planted_fault_is_found() {
    let mut missed = Vec::new();
    for planted in planted::ALL {
        let report = stressed(&[std::slice::from_ref(&planted.kind)], &quick());
        let found = |failed: &&afterimage_lab::stress::Failed| {
            failed.case == planted.case && failed.why.contains(planted.verdict)
        };
        if !report.failures().any(|failed| found(&failed)) {
            missed.push(format!("{}\n{}", planted.kind.doc(), reproduced(&report)));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn without_sanitizing_bad_values_spread_in_space_and_time() {
    let registry = registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let of = |name: &str, case: &str, unsanitized: bool| {
        let kind = registry.get(name).expect("a built-in kind");
        let choice = StressOptions { case: Some(case.into()), defaults: true, unsanitized, ..quick() };
        stress(&gpu(), &kinds(&registry, &[std::slice::from_ref(kind)]).0, &choice, &())
    };
    for (kind, case, verdict) in [
        ("Gaussian", "nan", "not finite"),
        ("Gaussian", "negative", "out of range"),
        ("AutoExposure", "mixed", "bad values spread"),
        ("Adapt", "bad-frame", "after 4 frames"),
    ] {
        assert_eq!(of(kind, case, false).failures().count(), 0, "{kind} fails by itself");
        let report = of(kind, case, true);
        let found = report.failures().any(|failed| failed.why.contains(verdict));
        assert!(found, "{kind}, {case}: {}", reproduced(&report));
        assert!(report.failures().all(|failed| failed.command.contains(" --unsanitized ")));
    }
}

#[test]
fn a_failed_case_comes_with_the_command_that_shows_it_again() {
    let planted = planted::ALL.iter().find(|planted| planted.kind.name() == "KneeOfNothing").expect("a planted fault");
    let report = stressed(&[std::slice::from_ref(&planted.kind)], &quick());
    let failed =
        report.failures().find(|failed| failed.command.contains("--set")).expect("it fails at an end of its domain");
    assert_eq!(
        failed.command,
        format!("afterimage stress --kind KneeOfNothing --set it.knee=0.0 --size 17x13 --case {}", failed.case)
    );
    let text = report.to_text(1);
    assert!(text.contains(&failed.command) && text.contains("more; `--all` lists them"), "{text}");
    assert!(
        text.trim_end().ends_with(&format!("{} cases, {} failed", report.cases(), report.failures().count())),
        "{text}"
    );
}
