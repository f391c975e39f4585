//! `afterimage check`: each pipeline as it is written, and at each of its tiers.

use std::path::Path;

use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::verify;

use crate::args::{CheckArgs, PipelineOptions};
use crate::failure::Failure;
use crate::pipeline::{Files, check_file, facts, plan_without_device, read_text, registry, split, tier_names};
use crate::terminal::{note, say};

pub(crate) fn run(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.nodes)?;
    if args.json {
        return json(args, &registry);
    }
    let mut failed = 0;
    for path in &args.pipelines {
        match one(path, args, &registry) {
            Ok(verdict) => say(&format!("{}: good{verdict}", path.display())),
            Err(failure) if failure.status == 1 => {
                note(&failure.text);
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

/// What is to be said of a good pipeline.
fn one(path: &Path, args: &CheckArgs, registry: &Registry) -> Result<String, Failure> {
    let (written, mut warnings) = check_file(path, registry, &args.options)?;
    let mut graphs = vec![(String::new(), written)];
    let tiers = other_tiers(path, &args.options)?;
    for tier in &tiers {
        let (graph, more) = check_file(path, registry, &at_tier(&args.options, tier))?;
        warnings.absorb(more);
        graphs.push((format!(" of tier `{tier}`"), graph));
    }
    let warnings = warnings.sorted();
    if !warnings.is_empty() {
        note(&warnings.render(Style::Coloured));
    }
    if args.plan {
        graphs.iter().try_for_each(|(tier, graph)| prove(graph, tier, args))?;
    }
    let named: Vec<String> = tiers.iter().map(|tier| format!("`{tier}`")).collect();
    let tiers = if named.is_empty() { String::new() } else { format!(", and so with {}", named.join(", ")) };
    Ok(format!("{tiers}{}", if args.plan { "; its plans are proved" } else { "" }))
}

/// The tiers to be checked beside the file as it is written; none if the command line asks for one.
fn other_tiers(path: &Path, options: &PipelineOptions) -> Result<Vec<String>, Failure> {
    if options.tier.is_some() { Ok(Vec::new()) } else { tier_names(path) }
}

/// The options for a tier. It may be another file, which need not ask the facts that this one asks.
fn at_tier(options: &PipelineOptions, tier: &str) -> PipelineOptions {
    PipelineOptions { tier: Some(tier.to_owned()), facts: Vec::new(), ..options.clone() }
}

/// PlanCache the pipeline at three sizes and lets the checker replay each plan.
fn prove(graph: &Graph, tier: &str, args: &CheckArgs) -> Result<(), Failure> {
    for size in [Size::new(1, 1), Size::new(641, 359), Size::new(3840, 2160)] {
        let plan = plan_without_device(graph, size, facts(&args.options)?, Default::default())?;
        verify(&plan).map_err(|faults| {
            let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Failure::machine(format!("the plan{tier} at {size} is wrong: {}", lines.join("; ")))
        })?;
    }
    Ok(())
}

fn json(args: &CheckArgs, registry: &Registry) -> Result<(), Failure> {
    let mut all = Diagnostics::default();
    for path in &args.pipelines {
        let written = said(path, registry, &args.options)?;
        let is_good = !written.has_errors();
        all.absorb(written);
        // Where the file itself is wrong, so are its tiers.
        for tier in if is_good { other_tiers(path, &args.options)? } else { Vec::new() } {
            all.absorb(said(path, registry, &at_tier(&args.options, &tier))?);
        }
    }
    let all = all.sorted();
    say(&format!("{:#}", all.to_json()));
    if all.has_errors() { Err(Failure { text: String::new(), status: 1 }) } else { Ok(()) }
}

/// All that a check says of a file.
fn said(path: &Path, registry: &Registry, options: &PipelineOptions) -> Result<Diagnostics, Failure> {
    let name = path.to_string_lossy();
    let text = read_text(path, "pipeline")?;
    let sets = options.sets.iter().map(|set| split(set, "--set")).collect::<Result<_, _>>()?;
    let options = CheckOptions { tier: options.tier.clone(), sets, loader: &Files };
    let checked =
        parse(&name, &text).and_then(|document| check(&document, registry, &options).map(|(_, warnings)| warnings));
    Ok(checked.unwrap_or_else(|errors| errors))
}
