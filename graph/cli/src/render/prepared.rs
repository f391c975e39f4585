//! A run of `render` before there is a device: the pipeline, its files and the plan of a typical frame.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use afterimage_graph::check::{Facts, Graph, GraphInput};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::NodeKind;
use afterimage_media::film::require_ffmpeg;
use afterimage_media::run_files;
use afterimage_plan::{HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan_without_tables};

use super::existing::check_films;
use super::metered::{Metered, has_meter, no_meter, unmetered};
use super::read::check_spaces;
use super::request::Request;
use super::target::{STANDARD, Target};
use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::pipeline::{self, PipelineSource, assignments, facts, typical_caps};

/// The size of a typical image.
pub(super) fn typical_size() -> Size {
    Size::new(1920, 1080)
}

/// A run of `render` before there is a device.
pub(super) struct Prepared<'a> {
    pub(super) request: Request<'a>,
    pub(super) graph: Graph,
    pub(super) facts: Facts,
    pub(super) options: Options,
}

impl Prepared<'_> {
    pub(super) fn typical_plan(&self) -> Option<Plan> {
        self.plan(typical_size())
    }

    /// The plan for a typical device: what frames leave for later ones, and the sizes of outputs, are the same on all.
    /// `None` if the pipeline cannot be planned at that size.
    pub(super) fn plan(&self, size: Size) -> Option<Plan> {
        let given = self.request.jobs.first().map_or(&[][..], |job| &job.sources);
        let is_given = |input: &&GraphInput| !input.optional || given.iter().any(|(name, _)| *name == input.name);
        let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
        // A pass that makes several images would make each of them look as if it followed from all that it reads.
        let options = Options { fuse: false, ..self.options };
        let (graph, facts) = (&self.graph, self.facts.clone());
        let request = pipeline::request(graph, size, facts, options, typical_caps(), &Requirement::typical);
        let given = HostInputs::all(size, graph.inputs.iter().filter(is_given), image);
        plan_without_tables(graph, &PlanRequest { given, ..request }).ok()
    }
}

/// Returns whether frames leave something for later ones. A pipeline without a plan is rendered as if they did, which
/// is never wrong.
pub(super) fn has_state(plan: Option<&Plan>) -> bool {
    plan.is_none_or(|plan| !plan.state().is_empty())
}

/// Reads the pipeline, finds all files, and claims those that are written. Without targets nothing is rendered.
pub(super) fn prepare<'a>(
    args: &'a RenderArgs,
    tables: &[&[NodeKind]],
    targets: impl FnOnce(&RenderArgs, &Graph) -> Result<Vec<Target>, Failure>,
) -> Result<Prepared<'a>, Failure> {
    let graph = PipelineSource::read(&args.pipeline, tables, &args.options.kinds)?.file().graph(&args.options)?;
    let facts = facts(&args.options)?;
    let named_inputs = assignments(&args.inputs, "--input")?;
    let request = Request::new(args, targets(args, &graph)?, &graph, named_inputs)?;
    // A frame of a sequence or of a host has the pixels that it has there, also where it is rendered alone.
    let is_of_many = args.captured.is_some() || request.jobs.iter().any(|job| job.frame.is_some());
    let one_frame = !is_of_many && !args.plan.bakes_stills();
    let options = Options { one_frame, ..args.plan.options() };
    check_spaces(&request)?;
    let mut prepared = Prepared { request, graph, facts, options };
    if let Some(name) = &args.meter {
        let plan = prepared.typical_plan();
        if let Some(plan) = plan.as_ref().filter(|plan| !has_meter(plan)) {
            return Err(no_meter(plan));
        }
        let reach = plan.iter().flat_map(unmetered).filter_map(|item| item.reach).max();
        prepared.request.continue_measured(Metered::read(name)?, reach.unwrap_or(0))?;
    }
    check_films(&prepared)?;
    let request = &mut prepared.request;
    for target in request.targets.iter().filter(|target| target.film.is_some()) {
        require_ffmpeg(Path::new(&target.file))?;
    }
    for (name, source) in request.jobs.iter().flat_map(|job| &job.sources) {
        let what = match request.films.contains_key(name) {
            true => "film",
            false if request.has_camera(name) => "camera",
            false => "image",
        };
        run_files::reads(&source.path, &format!("the {what} of input `{name}`"));
    }
    let mut outs: Vec<&PathBuf> = request.jobs.iter().flat_map(|job| &job.out).collect();
    // A film is the file of each of its frames.
    let of_film = |out: &PathBuf| request.targets.iter().any(|target| target.film.is_some() && *out == *target.file);
    let mut films = BTreeSet::new();
    outs.retain(|out| out.as_path() != Path::new(STANDARD) && (!of_film(out) || films.insert(*out)));
    for out in outs {
        if args.skip_existing { run_files::claims(out)? } else { run_files::writes(out)? }
    }
    args.json.iter().try_for_each(|out| run_files::writes(out))?;
    if !request.is_measuring() {
        prepared.graph = request.prepare(prepared.graph);
    }
    Ok(prepared)
}
