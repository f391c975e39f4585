//! `afterimage bench`: what a pipeline costs here, pass by pass, next to what the device could do.

use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::shown_path;
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_lab::bench::{self, BenchOptions};
use afterimage_media::{run_files, write_atomic};

use crate::args::BenchArgs;
use crate::device::{keep_pipeline_data, open_for};
use crate::failure::Failure;
use crate::pipeline::{PipelineSource, facts};
use crate::terminal::say_text;

pub(crate) fn run(args: &BenchArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let path = &args.pipeline;
    let read = || PipelineSource::read(path, tables, &args.options.kinds);
    let source = read()?;
    // Prints the warnings; the starts below do not print them again.
    source.file().graph(&args.options)?;
    args.json.iter().try_for_each(|out| run_files::writes(out))?;
    let gpu = open_for(&args.device, &args.plan)?;
    let load = || -> Result<Graph, Failure> { Ok(read()?.file().check(&args.options)?.0) };
    let options = BenchOptions {
        size: Size::new(args.size.0, args.size.1),
        samples: args.frames,
        finite: args.finite,
        facts: facts(&args.options)?,
        options: args.plan.options(),
    };
    let report = bench::bench(&gpu, &source.registry, &shown_path(path), &load, &options)?;
    keep_pipeline_data(&gpu, &report.pipelines);
    say_text(&report.to_string());
    match &args.json {
        Some(file) => {
            let text = serde_json::to_vec_pretty(&report).expect("names and finite numbers are JSON");
            Ok(write_atomic(file, &text)?)
        }
        None => Ok(()),
    }
}
