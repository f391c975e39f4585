//! `afterimage render`: images through a pipeline.

mod bands;
mod existing;
mod frames;
mod jobs;
mod meter;
mod metered;
mod read;
mod readings;
mod repairs;
mod request;
mod stages;
mod target;
mod times;
mod watch_cache;
mod write;

use std::time::Instant;

use afterimage_graph::check::{Facts, Graph, GraphInput};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::NodeKind;
use afterimage_media::run_files;
use afterimage_plan::{HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan_without_tables};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::{self, PipelineFile, assignments, facts, typical_caps};
use crate::terminal::note;
use metered::{Metered, has_meter, no_meter, unmetered};
use read::check_spaces;
use readings::{FrameReport, Outcome, Report};
use request::Request;
use target::{Target, targets};
use times::Times;

pub(crate) use jobs::tell_other_numbers;
pub(crate) use meter::run as meter;
pub(crate) use target::choose_output;
pub(crate) use watch_cache::WatchCache;

/// The frames of a run.
pub(crate) struct Sequence {
    /// Their numbers in order; none for a single image.
    pub(crate) frames: Vec<u32>,
    /// Those that begin a new shot.
    pub(crate) cuts: Vec<u32>,
    /// The files that are written, with placeholders.
    pub(crate) files: Vec<String>,
    /// True if a frame leaves something for later ones.
    pub(crate) has_state: bool,
    /// True if all of that follows from what frames measure, each alone, and from the frames just before.
    pub(crate) is_metered: bool,
    /// The distance of two frames, if all have the same; 1 for one frame.
    pub(crate) step: Option<u32>,
    /// True if the sequence has a frame before the first of these, and that is no cut.
    pub(crate) begins_within: bool,
}

/// The frames that a run with these arguments would render.
pub(crate) fn sequence(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<Sequence, Failure> {
    let Prepared { request, graph, facts, options } = prepare(args, tables, targets)?;
    let plan = typical_plan(&request, &graph, facts, options, typical_size());
    // A pipeline that cannot be planned at that size is rendered as if it had state, which is never wrong.
    let has_state = plan.as_ref().is_none_or(|plan| !plan.state().is_empty());
    let is_metered =
        plan.as_ref().is_some_and(|plan| has_meter(plan) && unmetered(plan).all(|item| item.reach.is_some()));
    let frames: Vec<u32> = request.jobs.iter().filter(|job| job.is_written).filter_map(|job| job.frame).collect();
    let step = frames.first().zip(frames.get(1)).map_or(Some(1), |(first, second)| second.checked_sub(*first));
    let step = step.filter(|step| frames.windows(2).all(|pair| pair[1].checked_sub(pair[0]) == Some(*step)));
    let begins_within = request.earlier.is_some();
    let files = request.targets.into_iter().map(|target| target.file).collect();
    Ok(Sequence { frames, cuts: request.cuts.into_iter().collect(), files, has_state, is_metered, step, begins_within })
}

/// The result of [`prepare`].
struct Prepared<'a> {
    request: Request<'a>,
    graph: Graph,
    facts: Facts,
    options: Options,
}

/// Reads the pipeline, finds all files, and claims those that are written. Without targets nothing is rendered.
fn prepare<'a>(
    args: &'a RenderArgs,
    tables: &[&[NodeKind]],
    targets: impl FnOnce(&RenderArgs, &Graph) -> Result<Vec<Target>, Failure>,
) -> Result<Prepared<'a>, Failure> {
    let registry = registry(tables, &args.options.kinds)?;
    let document = read_document(&args.pipeline)?;
    let files = Files::of(&args.pipeline, &args.options.kinds);
    let graph = PipelineFile::new(&document, &registry, &files).graph(&args.options)?;
    let (facts, options) = (facts(&args.options)?, args.plan.options());
    let named_inputs = assignments(&args.inputs, "--input")?;
    let mut request = Request::new(args, targets(args, &graph)?, &graph, named_inputs)?;
    check_spaces(&request)?;
    if let Some(name) = &args.meter {
        let plan = typical_plan(&request, &graph, facts.clone(), options, typical_size());
        if let Some(plan) = plan.as_ref().filter(|plan| !has_meter(plan)) {
            return Err(no_meter(plan));
        }
        let reach = plan.iter().flat_map(unmetered).filter_map(|item| item.reach).max();
        request.continue_measured(Metered::read(name)?, reach.unwrap_or(0))?;
    }
    for (name, source) in request.jobs.iter().flat_map(|job| &job.sources) {
        let what = if request.has_camera(name) { "camera" } else { "image" };
        run_files::reads(&source.path, &format!("the {what} of input `{name}`"));
    }
    for out in request.jobs.iter().flat_map(|job| &job.out) {
        if args.skip_existing { run_files::claims(out)? } else { run_files::writes(out)? }
    }
    args.json.iter().try_for_each(|out| run_files::writes(out))?;
    let graph = if request.is_measuring() { graph } else { request.prepare(graph) };
    Ok(Prepared { request, graph, facts, options })
}

/// Renders. `cache` is that of a run with these arguments, if there may be another one.
pub(crate) fn run(
    args: &RenderArgs,
    tables: &[&[NodeKind]],
    cache: Option<&mut Option<WatchCache>>,
) -> Result<(), Failure> {
    let start = Instant::now();
    let Prepared { mut request, graph, facts, options } = prepare(args, tables, targets)?;
    let mut report = Report::default();
    if args.skip_existing {
        let plan = |size| typical_plan(&request, &graph, facts.clone(), options, size);
        let has_state = plan(typical_size()).is_none_or(|plan| !plan.state().is_empty());
        let done = existing::done(&request, plan);
        request.skip(&done, has_state);
        let skipped = request.skipped.iter();
        report.skipped = skipped.map(|job| FrameReport::without_picture(job, Outcome::Skipped, None)).collect();
    }
    let rendered = if request.jobs.is_empty() {
        Ok(Times::default())
    } else {
        stages::run(&request, (graph, facts, options), cache, &mut report)
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
    if args.timings {
        times.lines().iter().for_each(|line| note(line));
    }
    Ok(())
}

/// The size of a typical image.
fn typical_size() -> Size {
    Size::new(1920, 1080)
}

/// The plan for a typical device: what frames leave for later ones, and the sizes of outputs, are the same on all.
/// `None` if the pipeline cannot be planned at that size.
fn typical_plan(request: &Request<'_>, graph: &Graph, facts: Facts, options: Options, size: Size) -> Option<Plan> {
    let given = request.jobs.first().map_or(&[][..], |job| &job.sources);
    let is_given = |input: &&GraphInput| !input.optional || given.iter().any(|(name, _)| *name == input.name);
    let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    // A pass that makes several images would make each of them look as if it followed from all that the pass reads.
    let options = Options { fuse: false, ..options };
    let request = pipeline::request(graph, size, facts, options, typical_caps(), &Requirement::typical);
    let given = HostInputs::all(size, graph.inputs.iter().filter(is_given), image);
    plan_without_tables(graph, &PlanRequest { given, ..request }).ok()
}
