//! Offsets in one heap: images are rectangles, as high as their bytes and as long as their lives, that may not overlap.
//!
//! The least height is the most bytes that live at once, and no placement can be lower. Finding the best placement is NP-hard; the largest
//! first, each into the smallest gap that holds it, reaches the bound on most graphs of image passes. Where it does not, other orders are
//! tried, and then a search for a better skyline (`skyline`).

use std::cmp::Reverse;
use std::collections::BTreeSet;

use crate::{Alias, Plan, barriers, memory, skyline};

/// An image as the placement sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Its bytes.
    pub(crate) bytes: u64,
    /// Alignment of its offset; a power of two.
    pub(crate) alignment: u64,
    /// The first batch of its life.
    pub(crate) first: usize,
    /// The last batch of its life.
    pub(crate) last: usize,
}

/// Where blocks lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Placement {
    /// The offset of each block.
    pub(crate) offsets: Vec<u64>,
    /// The height: the highest end of a block.
    pub(crate) end: u64,
}

/// The most bytes that live at once.
pub(crate) fn lower_bound(blocks: &[Block]) -> u64 {
    let batches = blocks.iter().map(|block| block.last + 1).max().unwrap_or(0);
    let mut steps = vec![(0_u64, 0_u64); batches + 1];
    for block in blocks {
        steps[block.first].0 += block.bytes;
        steps[block.last + 1].1 += block.bytes;
    }
    let live = steps.iter().scan(0, |live, (born, gone)| {
        *live = *live + born - gone;
        Some(*live)
    });
    live.max().unwrap_or(0)
}

/// The lowest placement that a handful of orders and a short search find; `bound` is [`lower_bound`].
pub(crate) fn place(blocks: &[Block], bound: u64) -> Placement {
    let life = |at: usize| (blocks[at].last + 1 - blocks[at].first) as u128;
    let area = |at: usize| u128::from(blocks[at].bytes) * life(at);
    let soon = |at: usize| u128::MAX - blocks[at].first as u128;
    let mut order = by_size(blocks);
    let mut best = place_in(blocks, &order);
    let rules: [&dyn Fn(usize) -> u128; 3] = [&life, &area, &soon];
    for rule in rules {
        if best.end > bound {
            order.sort_by_key(|at| Reverse(rule(*at)));
            best = lower(best, place_in(blocks, &order));
        }
    }
    if best.end > bound { lower(best, skyline::search(blocks, bound)) } else { best }
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
    let mut room = Room::new(blocks);
    order.iter().for_each(|at| room.place(*at));
    room.placement()
}

/// Places the blocks that have an old offset there if it still fits, and the others around them.
fn place_around(blocks: &[Block], old: &[Option<u64>]) -> Placement {
    let mut room = Room::new(blocks);
    let keeps = |at: &usize| old[*at].is_some_and(|offset| room.place_at(*at, offset));
    let (_, homeless): (Vec<usize>, Vec<usize>) = by_size(blocks).into_iter().partition(keeps);
    homeless.into_iter().for_each(|at| room.place(at));
    room.placement()
}

/// A heap that fills up.
struct Room<'a> {
    blocks: &'a [Block],
    offsets: Vec<u64>,
    placed: Placed,
}

impl<'a> Room<'a> {
    fn new(blocks: &'a [Block]) -> Self {
        let batches = blocks.iter().map(|block| block.last + 1).max().unwrap_or(0);
        Self { blocks, offsets: vec![0; blocks.len()], placed: Placed::new(batches) }
    }

    /// The stretches that are taken at some time of the block's life, in ascending order.
    fn taken(&self, block: &Block) -> Vec<(u64, u64)> {
        let mut taken = Vec::new();
        self.placed.for_each_overlapping(block.first, block.last, &mut |other| {
            taken.push((self.offsets[other], self.offsets[other] + self.blocks[other].bytes));
        });
        taken.sort_unstable();
        taken
    }

    /// Into the smallest gap that holds it, the lowest of these; on top of everything else where none does.
    fn place(&mut self, at: usize) {
        let block = self.blocks[at];
        let (mut end, mut best) = (0, None::<(u64, u64)>);
        for (start, stop) in self.taken(&block) {
            let offset = u64::next_multiple_of(end, block.alignment);
            if offset + block.bytes <= start && best.is_none_or(|(gap, _)| start - end < gap) {
                best = Some((start - end, offset));
            }
            end = end.max(stop);
        }
        let offset = best.map_or(end.next_multiple_of(block.alignment), |(_, offset)| offset);
        self.put(at, offset);
    }

    /// At this offset, if it is free for all of the block's life.
    fn place_at(&mut self, at: usize, offset: u64) -> bool {
        let block = self.blocks[at];
        let is_free = |(start, stop): &(u64, u64)| offset + block.bytes <= *start || *stop <= offset;
        let fits = offset.is_multiple_of(block.alignment) && self.taken(&block).iter().all(is_free);
        if fits {
            self.put(at, offset);
        }
        fits
    }

    fn put(&mut self, at: usize, offset: u64) {
        self.offsets[at] = offset;
        self.placed.insert(at, self.blocks[at].first, self.blocks[at].last);
    }

    fn placement(self) -> Placement {
        let end = self.offsets.iter().zip(self.blocks).map(|(offset, block)| offset + block.bytes).max();
        Placement { end: end.unwrap_or(0), offsets: self.offsets }
    }
}

/// Placed blocks by their time: finds those that overlap a stretch of time without looking at the others (a segment tree for what is alive
/// at its beginning, a sorted set for what begins later).
struct Placed {
    leaves: usize,
    alive: Vec<Vec<usize>>,
    starts: BTreeSet<(usize, usize)>,
}

impl Placed {
    fn new(batches: usize) -> Self {
        let leaves = batches.next_power_of_two();
        Self { leaves, alive: vec![Vec::new(); 2 * leaves], starts: BTreeSet::new() }
    }

    fn insert(&mut self, at: usize, first: usize, last: usize) {
        self.starts.insert((first, at));
        let (mut low, mut high) = (first + self.leaves, last + 1 + self.leaves);
        while low < high {
            if low % 2 == 1 {
                self.alive[low].push(at);
                low += 1;
            }
            if high % 2 == 1 {
                high -= 1;
                self.alive[high].push(at);
            }
            low /= 2;
            high /= 2;
        }
    }

    fn for_each_overlapping(&self, first: usize, last: usize, visit: &mut dyn FnMut(usize)) {
        let mut node = first + self.leaves;
        while node > 0 {
            self.alive[node].iter().for_each(|at| visit(*at));
            node /= 2;
        }
        self.starts.range((first + 1, 0)..(last + 1, 0)).for_each(|(_, at)| visit(*at));
    }
}

impl Plan {
    /// Keeps the heap of an older plan, and every image that it shares with that plan in its old place, where all still fits; textures that lie
    /// where they lay need not be made again. Leaves the plan as it is where the old heap is too small, or more than twice too large.
    ///
    /// Images are the same if their names and their requirements are.
    pub fn place_keeping(&mut self, old: &Plan) -> bool {
        if self.options.alias != Alias::Placed || old.options.alias != Alias::Placed {
            return false;
        }
        let (images, blocks) = memory::blocks(&self.memory.requirement_of, &self.lifetimes);
        let placement = place_around(&blocks, &self.old_places(old, &images));
        if placement.end > old.memory.heap || old.memory.heap / 2 > self.memory.placed {
            return false;
        }
        self.memory.offset_of = memory::spread(self.lifetimes.len(), &images, &placement.offsets);
        self.memory.placed = placement.end;
        self.memory.heap = old.memory.heap;
        barriers::renew_hand_overs(self);
        true
    }

    fn old_places(&self, old: &Plan, images: &[usize]) -> Vec<Option<u64>> {
        let old_names = old.image_names();
        let old_images: std::collections::BTreeMap<&str, usize> =
            old_names.iter().enumerate().map(|(at, name)| (name.as_str(), at)).collect();
        let names = self.image_names();
        let place = |image: &usize| {
            let same = *old_images.get(names[*image].as_str())?;
            let equal = old.memory.requirement_of[same] == self.memory.requirement_of[*image];
            old.memory.offset_of[same].filter(|_| equal)
        };
        images.iter().map(place).collect()
    }
}
