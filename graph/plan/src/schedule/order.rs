//! The choice of an order.
//!
//! Several orders are tried, each is grouped into batches, and the best is kept. The order of recording is among them,
//! so the result is never worse than it, and it wins among equals, so that small edits of a file move little.

use super::batches::{fewest, within};
use super::list_scheduling::candidates;
use super::schedule_graph::ScheduleGraph;
use crate::options::Options;

/// The most orders of the same peak that are grouped into batches.
const GROUPED: usize = 4;
/// How often the orders that grouping has made are grouped again, at most.
const ROUNDS: usize = 4;

/// The best of the schedules that are tried, as batches of passes.
pub(super) fn choose(graph: &ScheduleGraph, options: &Options) -> Vec<Vec<usize>> {
    let schedules = schedules(graph);
    if options.serial {
        let orders = schedules.iter().map(|schedule| schedule.concat());
        let order = orders.min_by_key(|order| graph.peak(order)).unwrap_or_default();
        return order.into_iter().map(|pass| vec![pass]).collect();
    }
    let best = schedules.into_iter().min_by_key(|schedule| {
        let peak = graph.peak_of_batches(&mut schedule.iter().map(Vec::as_slice));
        let batches = schedule.len() as u64;
        if options.batches_first { (batches, peak) } else { (peak, batches) }
    });
    best.unwrap_or_default()
}

/// The orders of the smallest peak, grouped into batches, and after them the fewest batches that there can be. Grouping
/// pulls passes forward, and what these free may lower the peak: then the new orders are grouped again, within less.
fn schedules(graph: &ScheduleGraph) -> Vec<Vec<Vec<usize>>> {
    let fewest = fewest(graph);
    let listed = candidates(graph).into_iter();
    let mut orders = least(graph, listed.chain(fewest.iter().map(|schedule| schedule.concat())).collect());
    let mut schedules = Vec::new();
    for _ in 0..ROUNDS {
        let before = orders.first().map(|(peak, _)| *peak);
        let grouped: Vec<Vec<Vec<usize>>> = orders.iter().map(|(peak, order)| within(graph, order, *peak)).collect();
        orders = least(graph, grouped.iter().map(|schedule| schedule.concat()).collect());
        schedules.extend(grouped);
        if orders.first().map(|(peak, _)| *peak) >= before {
            break;
        }
    }
    schedules.extend(fewest);
    schedules
}

/// The orders whose peak is the smallest, a few at most, with it.
fn least(graph: &ScheduleGraph, orders: Vec<Vec<usize>>) -> Vec<(u64, Vec<usize>)> {
    let mut orders: Vec<(u64, Vec<usize>)> = orders.into_iter().map(|order| (graph.peak(&order), order)).collect();
    let least = orders.iter().map(|(peak, _)| *peak).min().unwrap_or(0);
    orders.retain(|(peak, _)| *peak == least);
    orders.truncate(GROUPED);
    orders
}
