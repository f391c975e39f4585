//! `afterimage tune`: tiers with the best quality switches for a budget or errors.

use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::list;
use afterimage_graph::node::NodeKind;
use afterimage_lab::measure::SequenceOptions;
use afterimage_lab::tune::{Goal, TunePipeline, TuneTarget, Tuned, changes, tune};
use afterimage_media::{run_files, write_atomic};

use crate::args::PipelineOptions;
use crate::args::measure::{Ladder, TuneArgs};
use crate::device::open;
use crate::failure::Failure;
use crate::measure::{measure_options, note_images};
use crate::pipeline::{PipelineFile, PipelineSource};
use crate::progress::Bar;
use crate::terminal::{note, say_text};
use crate::tier_file;

pub(crate) fn run(args: &TuneArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let pipeline = &args.sequences.options;
    let source = PipelineSource::read(&args.pipeline, tables, &pipeline.kinds)?;
    let (file, registry) = (source.file(), &source.registry);
    let written = file.graph(pipeline)?;
    let plain = without_changes(&file, pipeline, &written)?;
    // `--set` asks for another look, but a tier is a compromise: errors are measured against the file without it.
    let ideal = file.check(&PipelineOptions { tier: None, ..pipeline.clone() })?.0;
    note_images(&args.sequences);
    args.out.iter().chain(&args.state).try_for_each(|out| run_files::writes(out))?;
    let goals = goals(args);
    goals.iter().try_for_each(|goal| tier_file::check_name(args, registry, &goal.name))?;
    let gpu = open(&args.sequences.device)?;
    let mut options = measure_options(&args.sequences)?;
    if args.goal.tiers.is_some() && !args.no_charts {
        add_charts(&mut options.sequences, &written);
    }
    let tuned = TunePipeline { written, ideal, facts: pipeline.facts.clone() };
    let tuned = tune(&gpu, registry, &tuned, &options, &goals, args.state.as_deref(), &Bar::at_most())?;
    let entries: Vec<_> = tuned.tiers.iter().map(|tier| changes(&plain, &tier.graph)).collect();
    write(args, &tier_file::text(args, registry, &entries, &tuned)?)?;
    if let Some(folder) = tier_file::foreign_folder(args) {
        note(&format!("note: the file extends one of another folder; use it with `--allow {}`", folder.display()));
    }
    note_result(&tuned);
    let kept = file.tiers().into_iter().filter(|name| tuned.tiers.iter().all(|tier| tier.name != *name));
    if args.goal.tiers.is_some() && kept.clone().next().is_some() {
        let names = list(kept.collect::<Vec<_>>().iter().map(String::as_str), 16);
        note(&format!("note: the file inherits {names} from the pipeline"));
    }
    Ok(())
}

/// Adds the built-in pictures on which tiers are tuned, if the pipeline can take them.
fn add_charts(sequences: &mut SequenceOptions, graph: &Graph) {
    if sequences.charts_fit(graph) {
        // Without images, they would take the place of the built-in scene.
        sequences.scene |= sequences.images.is_empty();
        sequences.charts = true;
    } else {
        note("note: the pipeline cannot take `--charts`; lamps, dots, lines and motion may exceed the claims");
    }
}

/// Prints what is not in the file: the trade of each wire's format, goals without tiers, figures without claims.
fn note_result(tuned: &Tuned) {
    tuned.wires.iter().for_each(|wire| note(wire));
    tuned.left_out.iter().for_each(|reason| note(&format!("left out {reason}")));
    for tier in &tuned.tiers {
        note(&format!("`{}`: {}", tier.name, tier_file::figures(tier)));
    }
    note(&format!("{} choices were measured", tuned.choices));
}

fn write(args: &TuneArgs, text: &str) -> Result<(), Failure> {
    match &args.out {
        Some(path) => Ok(write_atomic(path, text.as_bytes())?),
        None => {
            say_text(text);
            Ok(())
        }
    }
}

fn goals(args: &TuneArgs) -> Vec<Goal> {
    if let Some(Ladder(tiers)) = &args.goal.tiers {
        return tiers.iter().map(|(name, codes)| Goal { name: name.clone(), target: step(*codes) }).collect();
    }
    let target = match args.goal.budget {
        Some(budget) => TuneTarget::Budget(budget),
        None => TuneTarget::Error(args.goal.error.unwrap_or(0.0)),
    };
    vec![Goal { name: args.name.clone(), target }]
}

/// The target of a tier of the ladder.
fn step(codes: f64) -> TuneTarget {
    if codes == 0.0 { TuneTarget::MostAccurate } else { TuneTarget::Error(codes) }
}

/// The graph of the file alone, which the new tiers change: changes of `--tier` and `--set` become part of them.
fn without_changes(file: &PipelineFile<'_>, options: &PipelineOptions, written: &Graph) -> Result<Graph, Failure> {
    let plain = file.check(&PipelineOptions { tier: None, sets: Vec::new(), ..options.clone() })?.0;
    let nodes = |graph: &Graph| -> Vec<_> {
        graph.nodes.iter().map(|node| (node.name.clone(), node.kind().name().to_owned(), node.wires.clone())).collect()
    };
    if nodes(&plain) == nodes(written) {
        return Ok(plain);
    }
    let tier = options.tier.as_deref().unwrap_or_default();
    Err(Failure::user(format!("the tier `{tier}` is another pipeline, not a choice of parameters"))
        .hint("tune the file that the tier names"))
}
