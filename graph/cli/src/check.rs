//! `afterimage check`: each pipeline as it is written, and at each of its tiers. `--fix` mends what is sure.

use std::collections::BTreeSet;
use std::path::Path;

use afterimage::host::built_in;
use afterimage_gpu::GpuError;
use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::{Diagnostics, Fix, Style, apply};
use afterimage_graph::document::without_mark;
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_media::rewrite;
use afterimage_plan::codegen::CodeOptions;
use afterimage_plan::{Plan, verify};
use afterimage_wgsl::Shader;

use crate::args::{CheckArgs, PipelineOptions};
use crate::failure::Failure;
use crate::files::text;
use crate::pipeline::{PipelineFile, PipelineSource, facts, plan_without_device};
use crate::terminal::{note, note_styled, say, say_text};

/// The most rounds of fixes in a file: a fixed error can uncover others.
const MAX_ROUNDS: usize = 8;

pub(crate) fn run(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.json {
        return json(args, tables);
    }
    let mut failed = 0;
    for path in &args.pipelines {
        match one(path, args, tables) {
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

/// Checks a pipeline, and prints its warnings; returns the rest of the line about a good one.
fn one(path: &Path, args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<String, Failure> {
    let (warnings, tiers) = examine(path, args, tables)?;
    if !warnings.is_empty() {
        note_styled(&warnings.render(Style::Colored));
    }
    if args.deny.is_some() && !warnings.is_empty() {
        return Err(Failure::user(format!("{}: `--deny warnings` permits no warning", path.display())));
    }
    let named: Vec<String> = tiers.iter().map(|tier| format!("`{tier}`")).collect();
    let tiers = if named.is_empty() { String::new() } else { format!(", also at {}", named.join(", ")) };
    Ok(format!("{tiers}{}", if args.plan { "; its plans are verified" } else { "" }))
}

/// Prints the diagnostics of all files as JSON. Every error is one of them, also a file that cannot be read.
fn json(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let mut all = Diagnostics::default();
    let mut status = 0;
    let mut add = |result: Result<Diagnostics, Failure>| match result {
        Ok(warnings) => {
            status = status.max(u8::from(args.deny.is_some() && !warnings.is_empty()));
            all.absorb(warnings);
        }
        Err(failure) => {
            status = status.max(failure.status());
            all.absorb(failure.into_diagnostics());
        }
    };
    for path in &args.pipelines {
        add(examine(path, args, tables).map(|(warnings, _)| warnings));
    }
    let all = all.sorted();
    say_text(&format!("{:#}", all.to_json()));
    if status == 0 { Ok(()) } else { Err(Failure::Printed { status }) }
}

/// The warnings of a file and of its tiers, and which tiers these are; or all errors, of the file if it has any,
/// otherwise of its tiers. With `--fix`, the file is mended before.
fn examine(path: &Path, args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(Diagnostics, Vec<String>), Failure> {
    if args.fix {
        mend(path, args, tables)?;
    }
    let source = PipelineSource::read(path, tables, &args.options.kinds)?;
    let file = source.file();
    let (graph, mut all) = file.check(&args.options)?;
    let mut graphs = vec![(String::new(), graph)];
    let mut has_failed = false;
    let tiers = other_tiers(&file, &args.options);
    for tier in &tiers {
        match file.check(&at_tier(&args.options, tier)) {
            Ok((graph, warnings)) => {
                all.absorb(warnings);
                graphs.push((format!(" of tier `{tier}`"), graph));
            }
            Err(failure) => {
                has_failed = true;
                all.absorb(failure.into_diagnostics());
            }
        }
    }
    if args.plan {
        let mut compiled = BTreeSet::new();
        graphs.iter().try_for_each(|(tier, graph)| verify_plans(graph, tier, args, &mut compiled))?;
    }
    let all = all.sorted();
    if has_failed { Err(all.into()) } else { Ok((all, tiers)) }
}

/// Replaces the words of a file for which the checks know the right ones, until they know of no more. What is left is
/// reported by the check that follows.
fn mend(path: &Path, args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if let Some((name, _)) = built_in(path) {
        return Err(Failure::user(format!("`{name}` is a built-in pipeline, which `--fix` cannot change"))
            .hint(format!("`afterimage pipelines {name} --write {name}.ron` writes it to a file")));
    }
    let args = CheckArgs { fix: false, plan: false, ..args.clone() };
    let name = path.to_string_lossy();
    for _ in 0..MAX_ROUNDS {
        let found = match examine(path, &args, tables) {
            Ok((warnings, _)) => warnings,
            Err(failure) => failure.into_diagnostics(),
        };
        let fixes = found.fixes(&name);
        let Some(checked) = found.sources.text(&name).filter(|_| !fixes.is_empty()) else { break };
        let written = text(path, "pipeline")?;
        // The text that was checked is without its byte order mark.
        let present = without_mark(&written);
        let (mark, _) = written.split_at(written.len() - present.len());
        if present != checked {
            return Err(Failure::user(format!(
                "{name}: the file has changed since it was checked, and is left as it is"
            ))
            .hint("run the command again"));
        }
        rewrite(path, format!("{mark}{}", apply(checked, &fixes)).as_bytes())?;
        fixes.iter().for_each(|fix| report_fix(fix, &found));
    }
    Ok(())
}

fn report_fix(fix: &Fix, found: &Diagnostics) {
    let file = &fix.location.file;
    let wrong = found.sources.text(file).map_or("", |text| &text[fix.location.span()]);
    let at = found
        .sources
        .position(file, fix.location.start)
        .map_or(String::new(), |at| format!(":{}:{}", at.line, at.column));
    note(&format!("mended: {file}{at}: `{wrong}` is now `{}`", fix.replacement));
}

/// The tiers to check besides the file as it is written; none if the command line names one.
fn other_tiers(file: &PipelineFile<'_>, options: &PipelineOptions) -> Vec<String> {
    if options.tier.is_some() { Vec::new() } else { file.tiers() }
}

/// The options for a tier. It may be another file, which need not use the facts that this one uses.
fn at_tier(options: &PipelineOptions, tier: &str) -> PipelineOptions {
    PipelineOptions { tier: Some(tier.to_owned()), facts: Vec::new(), ..options.clone() }
}

/// Plans the pipeline at three sizes, verifies each plan, and compiles its modules, but for those that were.
fn verify_plans(graph: &Graph, tier: &str, args: &CheckArgs, compiled: &mut BTreeSet<String>) -> Result<(), Failure> {
    for size in [Size::new(1, 1), Size::new(641, 359), Size::new(3840, 2160)] {
        let plan = plan_without_device(graph, size, facts(&args.options)?, Default::default())?;
        verify(&plan).map_err(|faults| {
            let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Failure::machine(format!("the plan{tier} at {size} is wrong: {}", lines.join("; ")))
        })?;
        compile(&plan, compiled)?;
    }
    Ok(())
}

/// Compiles the modules of folders, as far as that needs no device. Those of Rust have tests.
fn compile(plan: &Plan, compiled: &mut BTreeSet<String>) -> Result<(), Failure> {
    for (index, planned) in plan.passes.iter().enumerate() {
        if !planned.pass.shaders().any(Shader::is_untrusted) {
            continue;
        }
        let composed = plan
            .compose(index, CodeOptions { immediates: true, ..Default::default() })
            .map_err(|error| GpuError::Shader(error.into()))?;
        if compiled.insert(composed.source.clone()) {
            composed.validate().map_err(|error| GpuError::Shader(error.into()))?;
        }
    }
    Ok(())
}
