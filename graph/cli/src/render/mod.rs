//! `afterimage render`: images through a pipeline.

mod bands;
mod existing;
mod frames;
mod jobs;
mod meter;
mod metered;
mod prepared;
mod read;
mod readings;
mod request;
mod stages;
mod target;
mod times;
mod watch_cache;
mod write;

use std::time::Instant;

use afterimage_graph::node::NodeKind;

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::terminal::note;
use metered::{has_meter, unmetered};
use prepared::{Prepared, has_state, prepare};
use readings::{FrameReport, Outcome, Report};
use target::targets;
use times::Times;

pub(crate) use jobs::tell_other_numbers;
pub(crate) use meter::run as meter;
pub(crate) use target::choose_output;
pub(crate) use watch_cache::WatchCache;

#[cfg(feature = "view")]
pub(crate) use {read::volume, request::check_input_names};

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
    let prepared = prepare(args, tables, targets)?;
    let plan = prepared.typical_plan();
    let has_state = has_state(plan.as_ref());
    let request = prepared.request;
    let is_metered =
        plan.as_ref().is_some_and(|plan| has_meter(plan) && unmetered(plan).all(|item| item.reach.is_some()));
    let frames: Vec<u32> = request.jobs.iter().filter(|job| job.is_written).filter_map(|job| job.frame).collect();
    let step = frames.first().zip(frames.get(1)).map_or(Some(1), |(first, second)| second.checked_sub(*first));
    let step = step.filter(|step| frames.windows(2).all(|pair| pair[1].checked_sub(pair[0]) == Some(*step)));
    let begins_within = request.earlier.is_some();
    let files = request.targets.into_iter().map(|target| target.file).collect();
    Ok(Sequence { frames, cuts: request.cuts.into_iter().collect(), files, has_state, is_metered, step, begins_within })
}

/// Renders. `cache` is that of a run with these arguments, if there may be another one.
pub(crate) fn run(
    args: &RenderArgs,
    tables: &[&[NodeKind]],
    cache: Option<&mut Option<WatchCache>>,
) -> Result<(), Failure> {
    let start = Instant::now();
    let mut prepared = prepare(args, tables, targets)?;
    existing::check_films(&prepared)?;
    let mut report = Report::default();
    if args.skip_existing {
        let (done, has_state) = existing::done(&prepared);
        prepared.request.skip(&done, has_state);
        let skipped = prepared.request.skipped.iter();
        report.skipped = skipped.map(|job| FrameReport::without_picture(job, Outcome::Skipped, None)).collect();
    }
    let Prepared { request, graph, facts, options } = prepared;
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
