//! `afterimage stress`: every pipeline and every kind with extreme inputs.

mod processes;

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::available_parallelism;

use afterimage::host::built_in;
use afterimage_graph::check::{Checker, Graph};
use afterimage_graph::diagnostic::{Diagnostics, did_you_mean, shown};
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_lab::shell_word;
use afterimage_lab::stress::{self, StressOptions, Target};
use afterimage_media::{run_files, write_atomic};
use afterimage_pipelines::{BuiltIn, PIPELINES};
use afterimage_plan::Options;

use crate::args::stress::StressArgs;
use crate::device::open;
use crate::failure::Failure;
use crate::files::{Files, folder_kinds, read_document, text, with_own};
use crate::pipeline::{assignments, check_facts, facts, list_files};
use crate::process::Again;
use crate::progress::Bar;
use crate::terminal::{note, say_text};

/// Failed cases that are listed for each pipeline and kind without `--all`.
const LISTED: usize = 8;

pub(crate) fn run(args: &StressArgs, tables: &[&[NodeKind]], again: Option<&Again>) -> Result<(), Failure> {
    if let Some(case) = args.case.as_ref().filter(|case| !stress::is_case(case)) {
        return Err(unknown_case(case));
    }
    let (targets, skipped) = targets(args, tables)?;
    let options = StressOptions {
        case: args.case.clone(),
        size: args.size,
        defaults: args.defaults || !args.options.sets.is_empty(),
        quick: args.quick,
        unsanitized: args.unsanitized,
        tenth: None,
        options: Options::default(),
    };
    if let Some(at) = args.target {
        return one_target(args, &targets, at, &options);
    }
    args.json.iter().try_for_each(|out| run_files::writes(out))?;
    skipped.iter().for_each(|kind| note(kind));
    let gpu = open(&args.device)?;
    let cores = || available_parallelism().map_or(1, usize::from);
    let jobs = args.jobs.map_or_else(cores, usize::from).min(targets.len());
    let report = match again {
        Some(again) if jobs > 1 => {
            // It was opened for its errors.
            drop(gpu);
            processes::stress(again, &targets, jobs)?
        }
        _ => stress::stress(&gpu, &targets, &options, &Bar::new(targets.len() as u64)),
    };
    if let Some(path) = &args.json {
        write_atomic(path, &serde_json::to_vec_pretty(&report).expect("names and numbers are JSON"))?;
    }
    say_text(&report.to_text(if args.all { usize::MAX } else { LISTED }));
    match report.failures().count() {
        0 => Ok(()),
        _ => Err(Failure::Printed { status: 1 }),
    }
}

/// Runs one target of the list for the process that has started this one, and prints its results.
fn one_target(args: &StressArgs, targets: &[Target], at: usize, options: &StressOptions) -> Result<(), Failure> {
    processes::end_with_parent()?;
    let target = targets.get(at..).and_then(|rest| rest.get(..1));
    let target = target.ok_or_else(|| Failure::user(format!("`--target {at}`: there are {}", targets.len())))?;
    let report = stress::stress(&open(&args.device)?, target, options, &());
    say_text(&serde_json::to_string(&report.results[0]).expect("names and numbers are JSON"));
    Ok(())
}

fn unknown_case(case: &str) -> Failure {
    let names = stress::case_names();
    let hint =
        did_you_mean(case, names.iter().copied()).unwrap_or_else(|| format!("the cases are `{}`", names.join("`, `")));
    Failure::user(format!("no case is called `{case}`")).hint(hint)
}

/// The kinds of tables and of folders, with those that make values visible.
fn registry(tables: &[&[NodeKind]], folders: &[NodeKind]) -> Result<Arc<Registry>, Failure> {
    stress::registry(&[tables, &[folders]].concat()).map_err(Failure::user)
}

/// The targets that the command line names, with its overrides and facts.
fn targets(args: &StressArgs, tables: &[&[NodeKind]]) -> Result<(Vec<Target>, Vec<String>), Failure> {
    let from_folders = folder_kinds(&args.options.kinds)?;
    let named = registry(tables, &from_folders)?;
    let everything = args.pipelines.is_empty() && args.kind.is_empty() && !args.kinds;
    let tier = args.options.tier.as_deref();
    let (mut targets, mut skipped) = (Vec::new(), Vec::new());
    for path in &args.pipelines {
        if let Some((name, text)) = built_in(path) {
            targets.extend(of_built_in(name, text, &named, tier)?);
            continue;
        }
        let file = path.to_string_lossy();
        let document = read_document(path)?;
        let text = text(path, "pipeline")?;
        let own = registry(tables, &folder_kinds(&with_own(&args.options.kinds, Some(path)))?)?;
        // A target may live as long as the program.
        let files: &Files = Box::leak(Box::new(Files::of(path, &args.options.kinds)));
        list_files(&Checker::new(&document, &own, files), files);
        let name = shown(&file);
        targets.extend(stress::pipelines(&name, &shell_word(&name), &file, &text, &own, files, tier)?);
    }
    if everything {
        for (name, text) in PIPELINES {
            targets.extend(of_built_in(name, text, &named, tier)?);
        }
    }
    if everything || args.kinds {
        let (alone, others) = stress::kinds(&named, &[tables, &[&from_folders]].concat());
        targets.extend(alone);
        skipped.extend(others);
    }
    for name in &args.kind {
        let (alone, others) = one_kind(&named, name)?;
        targets.extend(alone);
        skipped.extend(others);
    }
    targets.retain(|target| target.bare || !args.bare);
    let base = assignments(&args.options.sets, "--set")?;
    check_fact_names(args, &targets)?;
    let facts = facts(&args.options)?;
    let more = further_words(args);
    targets = targets.iter().map(|target| target.with_words(&more)).collect();
    targets.iter_mut().for_each(|target| (target.base, target.facts) = (base.clone(), facts.clone()));
    Ok((targets, skipped))
}

/// The options without which a printed command has other kinds or other facts.
fn further_words(args: &StressArgs) -> String {
    let folders = |option: &'static str, folders: &[PathBuf]| {
        let names = folders.iter().map(|folder| folder.to_string_lossy().into_owned());
        names.map(|name| (option, name)).collect::<Vec<_>>()
    };
    let kinds = &args.options.kinds;
    let facts = args.options.facts.iter().map(|fact| ("--fact", fact.clone()));
    let all = folders("--nodes", &kinds.nodes).into_iter().chain(folders("--allow", &kinds.allow)).chain(facts);
    all.map(|(option, word)| format!(" {option} {}", shell_word(&word))).collect()
}

/// The targets of a built-in pipeline.
fn of_built_in(name: &str, text: &str, registry: &Arc<Registry>, tier: Option<&str>) -> Result<Vec<Target>, Failure> {
    Ok(stress::pipelines(name, name, &format!("{name}.ron"), text, registry, &BuiltIn, tier)?)
}

/// A fact that none of the targets knows is a typing error.
fn check_fact_names(args: &StressArgs, targets: &[Target]) -> Result<(), Failure> {
    let graphs: Vec<Graph> = targets.iter().filter_map(|target| target.graph(&Vec::new()).ok()).collect();
    for fact in &args.options.facts {
        let given = std::slice::from_ref(fact);
        let mut checks = graphs.iter().map(|graph| check_facts(graph, &[], given, &mut Diagnostics::default()));
        let first = checks.next().unwrap_or(Ok(()));
        if first.is_err() && !checks.any(|check| check.is_ok()) {
            return first;
        }
    }
    Ok(())
}

fn one_kind(registry: &Arc<Registry>, name: &str) -> Result<(Vec<Target>, Vec<String>), Failure> {
    let kind = registry.get(name).ok_or_else(|| {
        let hint = did_you_mean(name, registry.names()).unwrap_or_else(|| "`afterimage nodes` lists them all".into());
        Failure::user(format!("no node kind is called `{name}`")).hint(hint)
    })?;
    match stress::kinds(registry, &[std::slice::from_ref(kind)]) {
        (targets, skipped) if targets.is_empty() => Err(Failure::user(skipped.join("; "))),
        found => Ok(found),
    }
}
