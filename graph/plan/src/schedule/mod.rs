//! Scheduling: the order of passes, and the batches that they form.

mod batches;
mod list_scheduling;
mod order;
mod profile;
mod schedule_graph;

use std::ops::Range;

use crate::options::Options;
use crate::plan::{PlannedImage, ScheduledPass, Stage};
use schedule_graph::ScheduleGraph;

/// Passes in the order in which they run.
pub(crate) struct Schedule {
    pub(crate) passes: Vec<ScheduledPass>,
    /// Ranges of passes that need no barrier between them.
    pub(crate) batches: Vec<Range<usize>>,
}

/// Orders the passes and groups them into batches.
pub(crate) fn schedule(
    passes: Vec<ScheduledPass>,
    images: &[PlannedImage],
    buffers: usize,
    options: &Options,
) -> Schedule {
    let graph = ScheduleGraph::new(&passes, images, buffers);
    let mut chosen = order::choose(&graph, options);
    group_stages(&mut chosen, &passes);
    let mut waiting: Vec<Option<ScheduledPass>> = passes.into_iter().map(Some).collect();
    let mut schedule = Schedule { passes: Vec::with_capacity(waiting.len()), batches: Vec::new() };
    for batch in chosen {
        let start = schedule.passes.len();
        for pass in batch {
            schedule.passes.push(waiting[pass].take().expect("an order names each pass once"));
        }
        schedule.batches.push(start..schedule.passes.len());
    }
    schedule
}

/// Inside a batch the order is free: passes of one stage stand together, and a batch begins as the one before ended,
/// because each change between dispatches and draws costs a pass of the device.
fn group_stages(batches: &mut [Vec<usize>], passes: &[ScheduledPass]) {
    let mut running = Stage::Compute;
    for batch in batches {
        batch.sort_by_key(|pass| (passes[*pass].stage != running, *pass));
        running = batch.last().map_or(running, |pass| passes[*pass].stage);
    }
}
