//! Offsets in one heap: images, as rectangles of bytes and time, must not overlap.
//!
//! The least height is the most bytes that live at once, and no placement can be lower. Finding the best placement is
//! NP-hard; the largest first, each into the smallest gap that holds it, reaches the bound on most graphs of image
//! passes. Where it does not, other orders are tried, and then a search for a better skyline.

use std::cmp::Reverse;

use super::best_fit::BestFit;
use super::block::{Block, Placement};
use super::skyline::search;

/// With more blocks than this, only the first order is tried: blocks that all live at once take quadratic time.
const MOST_REORDERED: usize = 4096;

/// The lowest placement that a handful of orders and a short search find; `bound` is [`lower_bound`].
pub(super) fn place(blocks: &[Block], bound: u64) -> Placement {
    let life = |at: usize| (blocks[at].last + 1 - blocks[at].first) as u128;
    let area = |at: usize| u128::from(blocks[at].bytes) * life(at);
    let soon = |at: usize| u128::MAX - blocks[at].first as u128;
    let mut order = by_size(blocks);
    let mut best = place_in(blocks, &order);
    let rules: [&dyn Fn(usize) -> u128; 3] = [&life, &area, &soon];
    for rule in rules {
        if best.end > bound && blocks.len() <= MOST_REORDERED {
            order.sort_by_key(|at| Reverse(rule(*at)));
            best = lower(best, place_in(blocks, &order));
        }
    }
    if best.end > bound { lower(best, search(blocks, bound)) } else { best }
}

fn lower(first: Placement, second: Placement) -> Placement {
    if second.end < first.end { second } else { first }
}

/// The largest first; of equals the one that is used first.
fn by_size(blocks: &[Block]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    order.sort_by_key(|at| (Reverse(blocks[*at].bytes), blocks[*at].first, *at));
    order
}

fn place_in(blocks: &[Block], order: &[usize]) -> Placement {
    let mut heap = BestFit::new(blocks);
    order.iter().for_each(|at| heap.place(*at));
    heap.placement()
}

/// Places the blocks that have an old offset there if it still fits, and the others around them.
pub(crate) fn place_around(blocks: &[Block], old: &[Option<u64>]) -> Placement {
    let mut heap = BestFit::new(blocks);
    let keeps = |at: &usize| old[*at].is_some_and(|offset| heap.place_at(*at, offset));
    let (_, moved): (Vec<usize>, Vec<usize>) = by_size(blocks).into_iter().partition(keeps);
    moved.into_iter().for_each(|at| heap.place(at));
    heap.placement()
}
