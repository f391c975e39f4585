//! Offsets in one heap: images, as boxes of bytes and time, must not overlap.
//!
//! The least height is the most bytes that live at once, and no placement can be lower. Finding the best placement is
//! NP-hard; the largest first, each into the smallest gap that holds it, reaches the bound on most graphs of image
//! passes. Where it does not, a search changes the order at random and keeps the changes that do not raise the heap.

use std::cmp::Reverse;

use super::best_fit::BestFit;
use super::block::{Block, Placement};

/// Orders that the search tries from each of its first orders.
const TRIES: usize = 64;
/// Steps that these tries may take: placing blocks that all live at once takes quadratic time.
const STEPS: usize = 4_000_000;

/// The lowest placement that a short search finds; `bound` is [`lower_bound`](super::block::lower_bound).
pub(super) fn place(blocks: &[Block], bound: u64) -> Placement {
    let mut best = place_in(blocks, &by_size(blocks));
    let tries = TRIES.min(STEPS / (blocks.len() * blocks.len()).max(1));
    let bytes = |block: &Block| block.bytes as f64;
    let life = |block: &Block| (block.last + 1 - block.first) as f64;
    let first_ranks: [&dyn Fn(&Block) -> f64; 3] = [&life, &|block| bytes(block) * life(block), &bytes];
    let mut random = Lcg(1);
    for rank in first_ranks {
        let mut ranks: Vec<f64> = blocks.iter().map(rank).collect();
        let mut lowest = u64::MAX;
        for attempt in 0..tries {
            if best.end == bound {
                return best;
            }
            let changed = if attempt == 0 { ranks.clone() } else { random.change(&ranks) };
            let placement = place_in(blocks, &by_rank(&changed));
            if placement.end <= lowest {
                (lowest, ranks) = (placement.end, changed);
            }
            if placement.end < best.end {
                best = placement;
            }
        }
    }
    best
}

/// Random numbers that are always the same: a linear congruential generator (Knuth's MMIX constants).
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// Scales an eighth to a half of the ranks by 0.5 to 2.
    fn change(&mut self, ranks: &[f64]) -> Vec<f64> {
        let share = 1 + self.next() % 4;
        let mut scale = || match self.next() % 8 < share {
            true => 0.5 + 1.5 * (self.next() % 1024) as f64 / 1024.0,
            false => 1.0,
        };
        ranks.iter().map(|rank| rank * scale()).collect()
    }
}

/// The largest first; of equals the one that is used first.
fn by_size(blocks: &[Block]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    order.sort_by_key(|at| (Reverse(blocks[*at].bytes), blocks[*at].first, *at));
    order
}

/// The highest rank first.
fn by_rank(ranks: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..ranks.len()).collect();
    order.sort_by(|a, b| ranks[*b].total_cmp(&ranks[*a]));
    order
}

fn place_in(blocks: &[Block], order: &[usize]) -> Placement {
    let mut heap = BestFit::new(blocks);
    for at in order {
        heap.place(*at);
    }
    heap.placement()
}

/// Places the blocks that have an old offset there if it still fits, and the others around them.
pub(crate) fn place_around(blocks: &[Block], old: &[Option<u64>]) -> Placement {
    let mut heap = BestFit::new(blocks);
    let keeps = |at: &usize| old[*at].is_some_and(|offset| heap.place_at(*at, offset));
    let (_, moved): (Vec<usize>, Vec<usize>) = by_size(blocks).into_iter().partition(keeps);
    for at in moved {
        heap.place(at);
    }
    heap.placement()
}

#[cfg(test)]
mod tests {
    use afterimage_generators::Rng;

    use super::super::block::lower_bound;
    use super::*;

    fn blocks(rng: &mut Rng, count: usize) -> Vec<Block> {
        let block = |_| {
            let (first, length) = (rng.below(8), rng.below(4));
            let alignment = 1 << (4 + 2 * rng.below(3));
            Block { bytes: 16 * (1 + rng.below(40) as u64), alignment, first, last: first + length }
        };
        (0..count).map(block).collect()
    }

    /// No two blocks share a byte and a batch, each is aligned, and the end is that of the highest.
    fn assert_valid(blocks: &[Block], placement: &Placement, what: &str) {
        for (at, (one, offset)) in blocks.iter().zip(&placement.offsets).enumerate() {
            assert!(offset.is_multiple_of(one.alignment), "{what}: {one:?} at {offset}");
            for (other, place) in blocks.iter().zip(&placement.offsets).take(at) {
                let in_time = one.first <= other.last && other.first <= one.last;
                let in_space = *offset < place + other.bytes && *place < offset + one.bytes;
                assert!(!(in_time && in_space), "{what}: {one:?} at {offset} and {other:?} at {place}");
            }
        }
        let ends = blocks.iter().zip(&placement.offsets).map(|(block, offset)| offset + block.bytes);
        assert_eq!(placement.end, ends.max().unwrap_or(0), "{what}");
    }

    /// The least end over all orders in which each block goes to the lowest place that is free.
    fn best(blocks: &[Block]) -> u64 {
        fn go(blocks: &[Block], placed: &mut Vec<(usize, u64)>, end: u64, best: &mut u64) {
            if end >= *best {
                return;
            }
            if placed.len() == blocks.len() {
                *best = end;
                return;
            }
            for at in (0..blocks.len()).filter(|at| placed.iter().all(|(other, _)| other != at)).collect::<Vec<_>>() {
                let block = blocks[at];
                let beside: Vec<(u64, u64)> = placed
                    .iter()
                    .filter(|(other, _)| blocks[*other].first <= block.last && block.first <= blocks[*other].last)
                    .map(|(other, offset)| (*offset, offset + blocks[*other].bytes))
                    .collect();
                let is_free =
                    |start: &u64| beside.iter().all(|(from, to)| start + block.bytes <= *from || *to <= *start);
                let starts = beside.iter().map(|(_, to)| to.next_multiple_of(block.alignment)).chain([0]);
                let start = starts.filter(is_free).min().expect("above all others is room");
                placed.push((at, start));
                go(blocks, placed, end.max(start + block.bytes), best);
                placed.pop();
            }
        }
        let mut found = u64::MAX;
        go(blocks, &mut Vec::new(), 0, &mut found);
        found
    }

    #[test]
    fn a_placement_of_few_blocks_is_about_the_best_there_is() {
        let (mut rng, mut wasted, mut exact) = (Rng::new(5), 0, 0);
        for _ in 0..60 {
            let blocks = blocks(&mut rng, 6);
            let bound = lower_bound(&blocks);
            let most = (0..12).map(|batch| {
                let alive = blocks.iter().filter(|block| (block.first..=block.last).contains(&batch));
                alive.map(|block| block.bytes).sum::<u64>()
            });
            assert_eq!(Some(bound), most.max());
            let (found, best) = (place(&blocks, bound), best(&blocks));
            assert_valid(&blocks, &found, "placed");
            assert!(bound <= best && best <= found.end, "{bound} <= {best} <= {}", found.end);
            wasted += found.end - best;
            exact += usize::from(found.end == best);
        }
        assert!(exact >= 50 && wasted <= 512, "{exact} of 60 are the best; {wasted} bytes too many");
    }

    #[test]
    fn the_lowest_of_many_orders_is_valid() {
        let (mut rng, mut better) = (Rng::new(9), 0);
        for count in [1, 2, 7, 20, 60] {
            for _ in 0..12 {
                let blocks = blocks(&mut rng, count);
                let (lowest, sorted) = (place(&blocks, lower_bound(&blocks)), place_in(&blocks, &by_size(&blocks)));
                assert_valid(&blocks, &lowest, "lowest");
                assert!(lowest.end <= sorted.end, "the lowest is kept");
                better += usize::from(lowest.end < sorted.end);
            }
        }
        assert!(better >= 10, "other orders are better than the first {better} times");
    }

    /// Blocks stay at the places that are asked for, as far as these are free.
    #[test]
    fn what_has_a_place_stays_there() {
        let mut rng = Rng::new(11);
        for _ in 0..60 {
            let blocks = blocks(&mut rng, 24);
            let old = place(&blocks, lower_bound(&blocks));
            let asked: Vec<Option<u64>> =
                old.offsets.iter().map(|offset| Some(*offset).filter(|_| rng.per_cent(70))).collect();
            let kept = place_around(&blocks, &asked);
            assert_valid(&blocks, &kept, "kept");
            let stayed = asked.iter().zip(&kept.offsets).filter(|(asked, offset)| **asked == Some(**offset)).count();
            assert_eq!(stayed, asked.iter().flatten().count(), "all of them fitted together before");
            let crooked: Vec<Option<u64>> = asked.iter().map(|offset| offset.map(|offset| offset + 1)).collect();
            assert_valid(&blocks, &place_around(&blocks, &crooked), "asked for places without alignment");
        }
    }
}
