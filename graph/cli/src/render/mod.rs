//! `afterimage render`: images through a pipeline.

mod frames;
mod read;
mod readings;
mod repairs;
mod request;
mod stages;
mod state;
mod target;
mod times;
mod write;

use std::time::Instant;

use afterimage_graph::check::{Facts, Graph, GraphInput};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::NodeKind;
use afterimage_media::write_atomic;
use afterimage_plan::{GivenImage, HostInputs, Options, PlanRequest, Requirement, plan_without_tables};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::{self, PipelineFile, assignments, facts, plan_options, typical_caps};
use crate::run_files::RunFiles;
use crate::terminal::note;
use readings::{FrameReport, Outcome, Report};
use request::Request;
use target::targets;
use times::Times;

pub(crate) use target::choose_output;

/// The frames of a run.
pub(crate) struct Sequence {
    /// Their numbers in order; none for a single image.
    pub(crate) frames: Vec<u32>,
    /// Those that begin a new shot.
    pub(crate) cuts: Vec<u32>,
    /// The files that are written, with placeholders.
    pub(crate) files: Vec<String>,
    /// Whether a frame leaves something for later ones.
    pub(crate) has_state: bool,
}

/// The frames that a run with these arguments would render.
pub(crate) fn sequence(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<Sequence, Failure> {
    let Prepared { request, graph, facts, options } = prepare(args, tables, &RunFiles::default())?;
    let has_state = has_state(&request, &graph, facts, options);
    let frames = request.jobs.iter().filter(|job| job.is_written).filter_map(|job| job.frame).collect();
    let files = request.targets.into_iter().map(|target| target.file).collect();
    Ok(Sequence { frames, cuts: request.cuts, files, has_state })
}

/// What is known before a run.
struct Prepared<'a> {
    request: Request<'a>,
    graph: Graph,
    facts: Facts,
    options: Options,
}

/// Reads the pipeline, finds all files, and claims those that are written.
fn prepare<'a>(args: &'a RenderArgs, tables: &[&[NodeKind]], run: &RunFiles) -> Result<Prepared<'a>, Failure> {
    let registry = registry(tables, &args.options.kinds, run)?;
    let document = read_document(&args.pipeline)?;
    let files = Files::of(&args.pipeline, &args.options.kinds, run);
    let graph = PipelineFile::new(&document, &registry, &files).graph(&args.options)?;
    let (facts, options) = (facts(&args.options)?, plan_options(&args.plan));
    let named_inputs = assignments(&args.inputs, "--input")?;
    let mut request = Request::new(args, targets(args, &graph)?, &graph, named_inputs)?;
    for (name, source) in request.jobs.iter().flat_map(|job| &job.sources) {
        run.reads(&source.path, &format!("the image of input `{name}`"));
    }
    if let Some(path) = &args.state_in {
        run.reads(path, "the state of `--state-in`");
    }
    let mut written = request.jobs.iter().flat_map(|job| &job.out).chain(&args.json).chain(&args.state_out);
    written.try_for_each(|out| run.writes(out))?;
    let graph = request.prepare(graph);
    Ok(Prepared { request, graph, facts, options })
}

pub(crate) fn run(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let start = Instant::now();
    let Prepared { mut request, graph, facts, options } = prepare(args, tables, &RunFiles::default())?;
    let mut report = Report::default();
    if args.skip_existing {
        request.skip_existing(has_state(&request, &graph, facts.clone(), options));
        let skipped = request.skipped.iter();
        report.skipped = skipped.map(|job| FrameReport::without_picture(job, Outcome::Skipped, None)).collect();
    }
    let rendered = if request.jobs.is_empty() {
        Ok(Times::default())
    } else {
        stages::run(&request, graph, facts, options, &mut report)
    };
    let failed = report.count(Outcome::Failed);
    let rendered = match rendered {
        Ok(_) if failed > 0 => {
            let all = report.frames.len() + report.skipped.len();
            Err(Failure::user(format!("{failed} of {all} frames failed")))
        }
        rendered => rendered,
    };
    report.summary().iter().for_each(|line| note(line));
    if let Some(path) = &args.json {
        report.write_json(path, &args.pipeline, start.elapsed().as_secs_f64(), rendered.as_ref().err())?;
    }
    let times = rendered?;
    if let Some((path, state)) = args.state_out.as_ref().zip(report.state) {
        write_atomic(path, &state)?;
    }
    if args.timings {
        note(&times.to_string());
    }
    Ok(())
}

/// Whether a frame leaves something for later ones. The plan is that of a typical device: what it keeps is the same on
/// all.
fn has_state(request: &Request<'_>, graph: &Graph, facts: Facts, options: Options) -> bool {
    let given = request.jobs.first().map_or(&[][..], |job| &job.sources);
    let is_given = |input: &&GraphInput| !input.optional || given.iter().any(|(name, _)| *name == input.name);
    let size = Size::new(1920, 1080);
    let image = GivenImage { desc: ImageDesc::new(size), finite: false };
    let request = pipeline::request(graph, size, facts, options, typical_caps(), &Requirement::typical);
    let given = HostInputs::everything(size, graph.inputs.iter().filter(is_given), image);
    // A pipeline that cannot be planned at that size is rendered as if it had state, which is never wrong.
    plan_without_tables(graph, &PlanRequest { given, ..request }).map_or(true, |plan| !plan.state().is_empty())
}
