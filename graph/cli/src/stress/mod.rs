//! `afterimage stress`: every pipeline and every kind against every extreme.
//!
//! `subjects` lists what is put under stress, [`stress`] runs it and gives a [`Report`]. Images are small and many are rendered in one
//! submission, so that tens of thousands of cases take minutes on a processor.

pub(crate) mod args;
mod conditioning;
mod images;
mod lab;
mod probes;
mod promises;
mod report;
mod run;
mod settings;
mod subject;
mod time;
mod variants;
mod verdicts;
mod wiring;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Facts;
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::document::parse;
use afterimage_graph::node::{DuplicateKind, NodeKind, Registry};
use afterimage_plan::Options;
use indicatif::{ProgressBar, ProgressStyle};

pub(crate) use conditioning::figures;
pub use conditioning::{Conditioning, conditioning};
pub use report::{Failed, Report, Tally};
pub use run::Choice;
pub use subject::Subject;

use crate::failure::Failure;
use crate::pipeline::{facts, read_text, split};
use crate::session::{open, options_on};
use crate::shipped::PIPELINES;
use crate::terminal::say;
use afterimage_media::write_atomic;
use args::StressArgs;

/// Failed cases that are listed for each pipeline and kind, unless all are asked for.
const LISTED: usize = 8;

/// The kinds of these tables and those that show what cannot be seen.
///
/// # Errors
/// Two kinds of the same name.
pub fn registry(tables: &[&[NodeKind]]) -> Result<Registry, DuplicateKind> {
    let mut all = tables.to_vec();
    all.push(probes::ALL);
    Registry::new(&all)
}

/// Every kind of these tables on its own: with its optional inputs, with light that may be negative, and without optional inputs where it
/// has any. Kinds that no wires from images reach are left out.
pub fn kinds(registry: &Registry, tables: &[&[NodeKind]]) -> Vec<Subject> {
    let mut subjects = Vec::new();
    for kind in tables.iter().copied().flatten() {
        subjects.extend(Subject::kind(registry, kind, false, false));
        subjects.extend(Subject::kind(registry, kind, false, true).filter(Subject::takes_pictures));
        if kind.inputs().iter().any(|port| port.optional) {
            subjects.extend(Subject::kind(registry, kind, true, false));
        }
    }
    subjects
}

/// Runs the chosen cases of each subject; `begins` is told the title of each.
pub fn stress(gpu: &Gpu, registry: &Registry, subjects: &[Subject], choice: &Choice, begins: &dyn Fn(&str)) -> Report {
    let mut lab = lab::Lab::new(gpu, choice.unguarded, choice.options);
    let mut report = Report::default();
    for subject in subjects {
        begins(&subject.title);
        report.tallies.push(run::stress(&mut lab, registry, subject, choice));
    }
    report
}

pub(crate) fn run(args: &StressArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let mut from_folders = Vec::new();
    for folder in &args.options.nodes {
        from_folders.extend(crate::pipeline::folder_kinds(folder)?);
    }
    let mut tables = tables.to_vec();
    tables.push(&from_folders);
    let registry = registry(&tables).map_err(Failure::user)?;
    if let Some(case) = args.case.as_ref().filter(|case| !is_case(case)) {
        return Err(unknown_case(case));
    }
    let subjects = subjects(args, &registry, &tables)?;
    let gpu = open(&args.device)?;
    let bar = progress(subjects.len());
    let begins = |title: &str| {
        bar.set_message(title.to_owned());
        bar.inc(1);
    };
    if args.conditioning {
        let all = conditioning(&gpu, &registry, &subjects, &begins);
        bar.finish_and_clear();
        return conditioning::report(args, &all);
    }
    let choice = Choice {
        case: args.case.clone(),
        size: args.size,
        defaults: args.defaults,
        quick: args.quick,
        unguarded: args.unguarded,
        options: options_on(&gpu, Options::default(), &args.device.arithmetic),
    };
    let choice = Choice { defaults: choice.defaults || !args.options.sets.is_empty(), ..choice };
    let report = stress(&gpu, &registry, &subjects, &choice, &begins);
    bar.finish_and_clear();
    if let Some(path) = &args.markdown {
        write_atomic(path, report.to_markdown(&gpu.name()).as_bytes())?;
    }
    say(&report.to_text(if args.all { usize::MAX } else { LISTED }));
    match report.failures().count() {
        0 => Ok(()),
        _ => Err(Failure { text: String::new(), status: 1 }),
    }
}

fn is_case(name: &str) -> bool {
    images::Extreme::named(name).is_some() || time::is_sequence(name) || name == "check"
}

fn unknown_case(case: &str) -> Failure {
    let names: Vec<&str> = images::ALL.iter().map(|image| image.name).chain(time::names()).collect();
    let hint =
        did_you_mean(case, names.iter().copied()).unwrap_or_else(|| format!("the cases are `{}`", names.join("`, `")));
    Failure::user(format!("no case is called `{case}`")).hint(hint)
}

fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}");
    ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// What the command line asks for, with its changes and facts.
fn subjects(args: &StressArgs, registry: &Registry, tables: &[&[NodeKind]]) -> Result<Vec<Subject>, Failure> {
    let everything = args.pipelines.is_empty() && args.kind.is_empty() && !args.kinds;
    let mut subjects = Vec::new();
    for path in &args.pipelines {
        let file = path.to_string_lossy();
        let text = read_text(path, "pipeline")?;
        let subject = |tier: Option<&str>| Subject::pipeline(&file, &file, &text, tier);
        subjects.extend(pipelines(&file, &text, args.options.tier.as_deref(), subject)?);
    }
    if everything {
        for (name, text) in PIPELINES {
            let subject = |tier: Option<&str>| Subject::shipped(name, text, tier);
            subjects.extend(pipelines(name, text, args.options.tier.as_deref(), subject)?);
        }
    }
    if everything || args.kinds {
        subjects.extend(kinds(registry, tables));
    }
    for name in &args.kind {
        subjects.extend(one_kind(registry, name)?);
    }
    subjects.retain(|subject| (subject.bare || !args.bare) && (subject.signed || !args.signed));
    let base = args.options.sets.iter().map(|set| split(set, "--set")).collect::<Result<Vec<_>, _>>()?;
    let facts: Facts = facts(&args.options)?;
    subjects.iter_mut().for_each(|subject| (subject.base, subject.facts) = (base.clone(), facts.clone()));
    Ok(subjects)
}

/// A pipeline, without its optional inputs, and in each of its tiers; or in the one that is asked for.
fn pipelines(
    file: &str,
    text: &str,
    tier: Option<&str>,
    subject: impl Fn(Option<&str>) -> Subject,
) -> Result<Vec<Subject>, Failure> {
    if tier.is_some() {
        return Ok(vec![subject(tier)]);
    }
    let whole = subject(None);
    let document = parse(file, text)?;
    let has_optional = document.inputs.iter().any(|input| input.optional);
    let mut subjects = vec![whole.clone()];
    subjects.extend(has_optional.then(|| whole.without_optional()));
    subjects.extend(document.tiers.iter().map(|(name, _)| subject(Some(&name.value))));
    Ok(subjects)
}

fn one_kind(registry: &Registry, name: &str) -> Result<Vec<Subject>, Failure> {
    let kind = registry.get(name).ok_or_else(|| {
        let hint = did_you_mean(name, registry.names()).unwrap_or_else(|| "`afterimage nodes` lists them all".into());
        Failure::user(format!("no node kind is called `{name}`")).hint(hint)
    })?;
    let subjects = kinds(registry, &[std::slice::from_ref(kind)]);
    if subjects.is_empty() {
        return Err(Failure::user(format!(
            "no wires from images reach all inputs of `{name}`, so it cannot run alone"
        )));
    }
    Ok(subjects)
}
