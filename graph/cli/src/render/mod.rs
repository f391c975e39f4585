//! `afterimage render`: images through a pipeline.

mod frames;
mod read;
mod readings;
mod repairs;
mod request;
mod stages;
mod target;
mod times;
mod write;

use afterimage_graph::node::NodeKind;

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::{PipelineFile, assignments, facts, plan_options};
use crate::run_files::RunFiles;
use crate::terminal::note;
use request::Request;
use target::targets;

pub(crate) use target::choose_output;

pub(crate) fn run(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let run = RunFiles::default();
    let registry = registry(tables, &args.options.kinds, &run)?;
    let document = read_document(&args.pipeline)?;
    let files = Files::of(&args.pipeline, &args.options.kinds, &run);
    let graph = PipelineFile::new(&document, &registry, &files).graph(&args.options)?;
    let (facts, options) = (facts(&args.options)?, plan_options(&args.plan));
    let named_inputs = assignments(&args.inputs, "--input")?;
    let mut request = Request::new(args, targets(args, &graph)?, &graph, named_inputs)?;
    for (name, source) in request.jobs.iter().flat_map(|job| &job.sources) {
        run.reads(&source.path, &format!("the image of input `{name}`"));
    }
    let mut written = request.jobs.iter().flat_map(|job| &job.out).chain(&args.json);
    written.try_for_each(|out| run.writes(out))?;
    let graph = request.prepare(graph);
    let (times, frames) = stages::run(&request, graph, facts, options)?;
    readings::summary(&frames).iter().for_each(|line| note(line));
    if let Some(path) = &args.json {
        readings::write_json(path, &frames)?;
    }
    if args.timings {
        note(&times.to_string());
    }
    Ok(())
}
