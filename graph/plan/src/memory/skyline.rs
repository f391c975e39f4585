//! Another placement: always at the lowest point of the skyline that the placed blocks make over time.
//!
//! The lowest stretch of the skyline takes a block that lives within it, by a rank that states which goes first; where
//! none does, the stretch is filled up to its lower neighbor. That loses nothing: no block that is left lives within
//! it.

use super::block::{Block, Placement, alive};

/// A stretch of time over which the top of what is placed is level.
#[derive(Clone, Copy, Debug)]
struct Level {
    start: usize,
    end: usize,
    height: u64,
}

/// Tries of one rule at most.
const TRIES: usize = 200;
/// Steps that all tries of a rule may take together: above some hundred blocks there are fewer tries.
const STEPS: usize = 4_000_000;

/// Searches for a placement as low as `bound`: the ranks of one rule after the other are changed at random, and a
/// change that does not raise the placement is kept.
pub(super) fn search(blocks: &[Block], bound: u64) -> Placement {
    let life = |at: usize| (blocks[at].last + 1 - blocks[at].first) as f64;
    let rules: [&dyn Fn(usize) -> f64; 3] =
        [&life, &|at| blocks[at].bytes as f64, &|at| blocks[at].bytes as f64 * life(at)];
    let tries = (STEPS / (blocks.len() * blocks.len()).max(1)).min(TRIES);
    let alive = alive(blocks);
    let mut shaker = Lcg(1);
    let mut best = Placement { end: u64::MAX, offsets: Vec::new() };
    for rule in rules {
        let mut ranks: Vec<f64> = (0..blocks.len()).map(rule).collect();
        let mut lowest = u64::MAX;
        for _ in 0..tries {
            let shaken = shaker.shake(&ranks);
            let Some(placement) = place(blocks, &alive, &shaken, lowest) else { continue };
            lowest = placement.end;
            ranks = shaken;
            if placement.end < best.end {
                best = placement;
            }
            if best.end == bound {
                return best;
            }
        }
    }
    best
}

/// Changes that look random and are always the same: a linear congruential generator (Knuth's MMIX constants).
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// Scales an eighth to a half of the ranks by 0.5 to 2.
    fn shake(&mut self, ranks: &[f64]) -> Vec<f64> {
        let share = 1 + self.next() % 4;
        let mut scale = || match self.next() % 8 < share {
            true => 0.5 + 1.5 * (self.next() % 1024) as f64 / 1024.0,
            false => 1.0,
        };
        ranks.iter().map(|rank| rank * scale()).collect()
    }
}

/// Places all blocks; of those that fit, the one with the highest rank goes first. `None` as soon as it is certain to
/// be higher than `limit`.
fn place(blocks: &[Block], alive: &[u64], ranks: &[f64], limit: u64) -> Option<Placement> {
    let mut skyline = vec![Level { start: 0, end: alive.len(), height: 0 }];
    // What is filled up is lost: in no batch may it and all that lives there exceed the limit.
    let mut needed = alive.to_vec();
    let mut offsets = vec![0; blocks.len()];
    let mut left: Vec<usize> = (0..blocks.len()).collect();
    left.sort_by(|a, b| ranks[*b].total_cmp(&ranks[*a]).then(a.cmp(b)));
    while !left.is_empty() {
        let lowest = (0..skyline.len()).min_by_key(|at| skyline[*at].height).expect("the skyline covers all time");
        let Level { start, end, height } = skyline[lowest];
        let fits = |at: &usize| start <= blocks[*at].first && blocks[*at].last < end;
        if let Some(found) = left.iter().position(fits) {
            let at = left.remove(found);
            offsets[at] = height.next_multiple_of(blocks[at].alignment);
            cover(&mut skyline, lowest, &blocks[at], offsets[at] + blocks[at].bytes);
        } else {
            let raised = fill(&mut skyline, lowest);
            needed[start..end].iter_mut().for_each(|bytes| *bytes += raised);
            if needed[start..end].iter().any(|bytes| *bytes > limit) {
                return None;
            }
        }
    }
    let end = skyline.iter().map(|level| level.height).max().unwrap_or(0);
    (end <= limit).then_some(Placement { end, offsets })
}

/// Lays a block upon a level.
fn cover(skyline: &mut Vec<Level>, at: usize, block: &Block, height: u64) {
    let Level { start, end, height: old } = skyline[at];
    let parts = [
        Level { start, end: block.first, height: old },
        Level { start: block.first, end: block.last + 1, height },
        Level { start: block.last + 1, end, height: old },
    ];
    skyline.splice(at..=at, parts.into_iter().filter(|level| level.start < level.end));
    join(skyline);
}

/// Raises a level to its lower neighbor; returns by how much.
fn fill(skyline: &mut Vec<Level>, at: usize) -> u64 {
    let neighbors = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|at| skyline.get(at));
    let lower = neighbors.map(|level| level.height).min().expect("a level over all time holds every block");
    let raised = lower - std::mem::replace(&mut skyline[at].height, lower);
    join(skyline);
    raised
}

fn join(skyline: &mut Vec<Level>) {
    skyline.dedup_by(|next, level| {
        level.end = if next.height == level.height { next.end } else { level.end };
        next.height == level.height
    });
}
