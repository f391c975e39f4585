//! `afterimage check`: each pipeline as it is written, and at each of its tiers.

use std::path::Path;

use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::verify;

use crate::args::{CheckArgs, PipelineOptions};
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::{PipelineFile, facts, plan_without_device};
use crate::run_files::RunFiles;
use crate::terminal::{note_styled, say};

pub(crate) fn run(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.json {
        return json(args, tables);
    }
    let registry = registry(tables, &args.options.kinds, &RunFiles::default())?;
    let mut failed = 0;
    for path in &args.pipelines {
        match one(path, args, &registry) {
            Ok(verdict) => say(&format!("{}: good{verdict}", path.display())),
            Err(failure) if failure.status() == 1 => {
                failure.print();
                failed += 1;
            }
            Err(failure) => return Err(failure),
        }
    }
    match failed {
        0 => Ok(()),
        _ => Err(Failure::user(format!("{failed} of {} pipelines cannot be used", args.pipelines.len()))),
    }
}

/// Checks a pipeline; returns the rest of the line about a good one.
fn one(path: &Path, args: &CheckArgs, registry: &Registry) -> Result<String, Failure> {
    let document = read_document(path)?;
    let files = Files::of(path, &args.options.kinds, &RunFiles::default());
    let file = PipelineFile::new(&document, registry, &files);
    let (written, mut warnings) = file.check(&args.options)?;
    let mut graphs = vec![(String::new(), written)];
    let tiers = other_tiers(&file, &args.options);
    for tier in &tiers {
        let (graph, more) = file.check(&at_tier(&args.options, tier))?;
        warnings.absorb(more);
        graphs.push((format!(" of tier `{tier}`"), graph));
    }
    let warnings = warnings.sorted();
    if !warnings.is_empty() {
        note_styled(&warnings.render(Style::Colored));
    }
    if args.plan {
        graphs.iter().try_for_each(|(tier, graph)| verify_plans(graph, tier, args))?;
    }
    let named: Vec<String> = tiers.iter().map(|tier| format!("`{tier}`")).collect();
    let tiers = if named.is_empty() { String::new() } else { format!(", also at {}", named.join(", ")) };
    Ok(format!("{tiers}{}", if args.plan { "; its plans are verified" } else { "" }))
}

/// The tiers to check besides the file as it is written; none if the command line names one.
fn other_tiers(file: &PipelineFile<'_>, options: &PipelineOptions) -> Vec<String> {
    if options.tier.is_some() { Vec::new() } else { file.tiers() }
}

/// The options for a tier. It may be another file, which need not use the facts that this one uses.
fn at_tier(options: &PipelineOptions, tier: &str) -> PipelineOptions {
    PipelineOptions { tier: Some(tier.to_owned()), facts: Vec::new(), ..options.clone() }
}

/// Plans the pipeline at three sizes and verifies each plan.
fn verify_plans(graph: &Graph, tier: &str, args: &CheckArgs) -> Result<(), Failure> {
    for size in [Size::new(1, 1), Size::new(641, 359), Size::new(3840, 2160)] {
        let plan = plan_without_device(graph, size, facts(&args.options)?, Default::default())?;
        verify(&plan).map_err(|faults| {
            let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Failure::machine(format!("the plan{tier} at {size} is wrong: {}", lines.join("; ")))
        })?;
    }
    Ok(())
}

/// Prints the diagnostics of all files as JSON. Every error is one of them, also a file that cannot be read.
fn json(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let mut all = Diagnostics::default();
    let mut status = 0;
    let mut add = |result: Result<Diagnostics, Failure>| match result {
        Ok(warnings) => all.absorb(warnings),
        Err(failure) => {
            status = status.max(failure.status());
            all.absorb(failure.into_diagnostics());
        }
    };
    match registry(tables, &args.options.kinds, &RunFiles::default()) {
        Ok(registry) => args.pipelines.iter().for_each(|path| add(diagnostics(path, args, &registry))),
        Err(failure) => add(Err(failure)),
    }
    let all = all.sorted();
    say(&format!("{:#}", all.to_json()));
    if status == 0 { Ok(()) } else { Err(Failure::Printed { status }) }
}

/// The warnings of a file and of its tiers; or all errors, of the file if it has any, otherwise of its tiers.
fn diagnostics(path: &Path, args: &CheckArgs, registry: &Registry) -> Result<Diagnostics, Failure> {
    let document = read_document(path)?;
    let files = Files::of(path, &args.options.kinds, &RunFiles::default());
    let file = PipelineFile::new(&document, registry, &files);
    let (graph, mut all) = file.check(&args.options)?;
    let mut graphs = vec![(String::new(), graph)];
    let mut failed = None;
    for tier in other_tiers(&file, &args.options) {
        match file.check(&at_tier(&args.options, &tier)) {
            Ok((graph, warnings)) => {
                all.absorb(warnings);
                graphs.push((format!(" of tier `{tier}`"), graph));
            }
            Err(failure) => {
                failed = failed.max(Some(failure.status()));
                all.absorb(failure.into_diagnostics());
            }
        }
    }
    if args.plan {
        graphs.iter().try_for_each(|(tier, graph)| verify_plans(graph, tier, args))?;
    }
    if failed.is_some() { Err(all.into()) } else { Ok(all) }
}
