//! Step 5: the order of passes, and the batches they form.
//!
//! Several orders are tried (`lists`), each is grouped into batches (`batches`), and the best is kept; the order of recording is among them, so
//! the result is never worse than it, and among equals the order of recording wins, so that small edits of a file move little.

use std::ops::Range;

use crate::schedule_graph::ScheduleGraph;
use crate::{Options, PlanBuilder, Requirement, Stage, batches, list_scheduling};
use afterimage_graph::node::Pass;

/// At most so many orders of the same peak are grouped into batches.
const GROUPED: usize = 4;
/// At most so often are the orders that grouping has made grouped again.
const ROUNDS: usize = 4;

/// What became of the passes.
pub(crate) struct Order {
    /// For each pass in the new order, its place in the recording.
    pub(crate) recorded: Vec<usize>,
    /// Ranges of the new order.
    pub(crate) batches: Vec<Range<usize>>,
}

/// Puts the passes, and the stages with them, into the order in which they run.
pub(crate) fn order(
    draft: &mut PlanBuilder,
    stages: &mut Vec<Stage>,
    requirements: &[Option<Requirement>],
    options: &Options,
) -> Order {
    let flow = ScheduleGraph::new(&draft.recording, requirements);
    let mut chosen = choose(&flow, options);
    group_stages(&mut chosen, stages);
    let recorded: Vec<usize> = chosen.concat();
    *stages = recorded.iter().map(|pass| stages[*pass]).collect();
    let mut passes: Vec<Option<Pass>> = std::mem::take(&mut draft.recording.passes).into_iter().map(Some).collect();
    draft.recording.passes =
        recorded.iter().map(|at| passes[*at].take().expect("an order names each pass once")).collect();
    let mut end = 0;
    let mut next = |batch: &Vec<usize>| {
        let start = end;
        end += batch.len();
        start..end
    };
    Order { batches: chosen.iter().map(&mut next).collect(), recorded }
}

fn choose(flow: &ScheduleGraph, options: &Options) -> Vec<Vec<usize>> {
    let schedules = schedules(flow);
    if options.serial {
        let orders = schedules.iter().map(|schedule| schedule.concat());
        let order = orders.min_by_key(|order| flow.peak(order)).unwrap_or_default();
        return order.into_iter().map(|pass| vec![pass]).collect();
    }
    let cost = |schedule: &Vec<Vec<usize>>| {
        let peak = flow.peak_of_batches(&mut schedule.iter().map(Vec::as_slice));
        let batches = schedule.len() as u64;
        if options.batches_first { (batches, peak) } else { (peak, batches) }
    };
    schedules.into_iter().min_by_key(cost).unwrap_or_default()
}

/// The orders of the smallest peak, grouped into batches, and after them the fewest batches that there can be. Grouping pulls passes forward, and
/// what these free may lower the peak: then the orders that came of it are grouped again, within less.
fn schedules(flow: &ScheduleGraph) -> Vec<Vec<Vec<usize>>> {
    let fewest = batches::fewest(flow);
    let listed = list_scheduling::candidates(flow).into_iter();
    let mut orders = least(flow, listed.chain(fewest.iter().map(|schedule| schedule.concat())).collect());
    let mut schedules = Vec::new();
    for _ in 0..ROUNDS {
        let before = orders.first().map(|(peak, _)| *peak);
        let grouped: Vec<Vec<Vec<usize>>> =
            orders.iter().map(|(peak, order)| batches::within(flow, order, *peak)).collect();
        orders = least(flow, grouped.iter().map(|schedule| schedule.concat()).collect());
        schedules.extend(grouped);
        if orders.first().map(|(peak, _)| *peak) >= before {
            break;
        }
    }
    schedules.extend(fewest);
    schedules
}

/// The orders whose peak is the smallest, a few at most, with it.
fn least(flow: &ScheduleGraph, orders: Vec<Vec<usize>>) -> Vec<(u64, Vec<usize>)> {
    let mut orders: Vec<(u64, Vec<usize>)> = orders.into_iter().map(|order| (flow.peak(&order), order)).collect();
    let least = orders.iter().map(|(peak, _)| *peak).min().unwrap_or(0);
    orders.retain(|(peak, _)| *peak == least);
    orders.truncate(GROUPED);
    orders
}

/// Inside a batch the order is free: passes of one stage stand together, and a batch begins as the one before ended, because each change
/// between dispatches and draws costs the executor a pass of the device.
fn group_stages(batches: &mut [Vec<usize>], stages: &[Stage]) {
    let mut running = Stage::Compute;
    for batch in batches {
        batch.sort_by_key(|pass| (stages[*pass] != running, *pass));
        running = batch.last().map_or(running, |pass| stages[*pass]);
    }
}
