//! The choice of an order.
//!
//! Several orders are tried, each is grouped into batches, and the best is kept. The order of recording is among them,
//! so the result is never worse than it, and it wins among equals, so that small edits of a file move little.

use super::batches::{Batches, fewest_batches, group_within_budget};
use super::list_scheduling::candidate_orders;
use super::schedule_graph::ScheduleGraph;
use crate::options::Options;

/// Orders of the same peak that are grouped into batches, at most.
const MAX_GROUPED_ORDERS: usize = 4;
/// Rounds of grouping the orders that grouping has produced, at most.
const MAX_ROUNDS: usize = 4;

/// The best of the schedules that are tried, as batches of passes.
pub(super) fn choose(graph: &ScheduleGraph, options: &Options) -> Batches {
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

/// The orders of the smallest peak of live bytes, grouped into batches, and after them the schedules with the fewest
/// batches. Grouping pulls passes forward. If what these free lowers the peak, the new orders are grouped again with
/// the lower peak as their budget.
fn schedules(graph: &ScheduleGraph) -> Vec<Batches> {
    let fewest = fewest_batches(graph);
    let orders = candidate_orders(graph).into_iter().chain(fewest.iter().map(|schedule| schedule.concat()));
    let mut orders = of_smallest_peak(graph, orders.collect());
    let mut schedules = Vec::new();
    for _ in 0..MAX_ROUNDS {
        let before = orders.first().map(|(peak, _)| *peak);
        let grouped: Vec<Batches> =
            orders.iter().map(|(peak, order)| group_within_budget(graph, order, *peak)).collect();
        orders = of_smallest_peak(graph, grouped.iter().map(|schedule| schedule.concat()).collect());
        schedules.extend(grouped);
        if orders.first().map(|(peak, _)| *peak) >= before {
            break;
        }
    }
    schedules.extend(fewest);
    schedules
}

/// The orders whose peak is the smallest, with this peak; at most [`MAX_GROUPED_ORDERS`].
fn of_smallest_peak(graph: &ScheduleGraph, orders: Vec<Vec<usize>>) -> Vec<(u64, Vec<usize>)> {
    let mut orders: Vec<(u64, Vec<usize>)> = orders.into_iter().map(|order| (graph.peak(&order), order)).collect();
    let smallest = orders.iter().map(|(peak, _)| *peak).min().unwrap_or(0);
    orders.retain(|(peak, _)| *peak == smallest);
    orders.truncate(MAX_GROUPED_ORDERS);
    orders
}
