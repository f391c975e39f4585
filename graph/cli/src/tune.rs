//! `afterimage tune`: a tier with the best quality switches for a budget or an error.

use afterimage_graph::check::Graph;
use afterimage_graph::node::NodeKind;
use afterimage_lab::tune::{PredictedError, Prediction, TunePipeline, TuneTarget, changes, random_errors, tune};
use afterimage_media::write_atomic;

use crate::args::PipelineOptions;
use crate::args::measure::{GoalArgs, TuneArgs};
use crate::device::open;
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::measure::{measure_options, note_images};
use crate::pipeline::PipelineFile;
use crate::progress::Bar;
use crate::run_files::RunFiles;
use crate::terminal::{note, say};
use crate::tier_file;

pub(crate) fn run(args: &TuneArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let pipeline = &args.clips.options;
    let run = RunFiles::default();
    let registry = registry(tables, &pipeline.kinds, &run)?;
    let document = read_document(&args.pipeline)?;
    let files = Files::of(&args.pipeline, &pipeline.kinds, &run);
    let file = PipelineFile::new(&document, &registry, &files);
    let written = file.graph(pipeline)?;
    let plain = without_changes(&file, pipeline, &written)?;
    // `--set` asks for another look, but a tier is a compromise: errors are measured against the file without it.
    let ideal = file.check(&PipelineOptions { tier: None, ..pipeline.clone() })?.0;
    note_images(&args.clips, &run);
    args.out.iter().chain(&args.state).try_for_each(|out| run.writes(out))?;
    tier_file::check_name(args, &registry)?;
    let gpu = open(&args.clips.device)?;
    let options = measure_options(&args.clips)?;
    let tuned = TunePipeline { written, ideal, facts: pipeline.facts.clone() };
    if let Some(count) = args.goal.random {
        let errors = random_errors(&gpu, &registry, &tuned, &options, count, &Bar::new(0))?;
        return write(args, &csv(&errors));
    }
    let (goal, state) = (goal(&args.goal), args.state.as_deref());
    let tuned = tune(&gpu, &registry, &tuned, &options, goal, state, &Bar::new(0))?;
    let text = tier_file::text(args, &registry, &changes(&plain, &tuned.graph), &tuned)?;
    write(args, &text)?;
    if let Some(folder) = tier_file::foreign_folder(args) {
        note(&format!("note: the file extends one of another folder; use it with `--allow {}`", folder.display()));
    }
    for Prediction { choice, predicted, measured } in &tuned.predictions {
        note(&format!("{choice}: {predicted:.3} codes predicted, {measured:.3} measured"));
    }
    note(&format!("{}; {} choices were compared", tier_file::figures(&tuned.measured), tuned.choices));
    Ok(())
}

fn write(args: &TuneArgs, text: &str) -> Result<(), Failure> {
    match &args.out {
        Some(path) => Ok(write_atomic(path, text.as_bytes())?),
        None => {
            say(text);
            Ok(())
        }
    }
}

/// Errors in codes, a line for each choice and image.
fn csv(errors: &[PredictedError]) -> String {
    let mut lines = vec!["choice,image,predicted,measured".to_owned()];
    for PredictedError { choice, image, predicted, measured } in errors {
        lines.push(format!("{},{},{predicted:.4},{measured:.4}", quoted(choice), quoted(image)));
    }
    lines.join("\n") + "\n"
}

/// A text as a cell of CSV.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

fn goal(args: &GoalArgs) -> TuneTarget {
    match (args.budget, args.error) {
        (Some(budget), _) => TuneTarget::Budget(budget),
        (None, error) => TuneTarget::Error(error.unwrap_or(0.0)),
    }
}

/// The pipeline as its file is, which the new tier changes: what `--tier` and `--set` change becomes part of the new
/// tier.
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
