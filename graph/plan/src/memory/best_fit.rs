//! Best fit: each block goes into the smallest gap that holds it.

use std::collections::BTreeMap;
use std::ops::Range;

use super::block::{Block, Placement};

/// A heap that fills up.
pub(super) struct BestFit<'a> {
    blocks: &'a [Block],
    offsets: Vec<u64>,
    placed: Placed,
}

impl<'a> BestFit<'a> {
    pub(super) fn new(blocks: &'a [Block]) -> Self {
        let batches = blocks.iter().map(|block| block.last + 1).max().unwrap_or(0);
        Self { blocks, offsets: vec![0; blocks.len()], placed: Placed::new(batches) }
    }

    /// The stretches that are taken at some time of the block's life, in ascending order.
    fn taken(&self, block: &Block) -> Vec<(u64, u64)> {
        let mut taken: Vec<(u64, u64)> = self.placed.overlapping(block.first, block.last).collect();
        // The stretches come as a few ascending runs, which a stable sort merges.
        taken.sort();
        taken
    }

    /// Places a block into the smallest gap that holds it, the lowest of these; on top of everything else where there
    /// is none.
    pub(super) fn place(&mut self, at: usize) {
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

    /// Places a block at this offset, if it is free for all of the block's life.
    pub(super) fn place_at(&mut self, at: usize, offset: u64) -> bool {
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
        let Block { bytes, first, last, .. } = self.blocks[at];
        self.placed.insert((offset, offset + bytes), at, first..last + 1);
    }

    pub(super) fn placement(self) -> Placement {
        let end = self.offsets.iter().zip(self.blocks).map(|(offset, block)| offset + block.bytes).max();
        Placement { end: end.unwrap_or(0), offsets: self.offsets }
    }
}

/// Placed blocks by their time: finds those that overlap a stretch of time without a look at the others (a segment tree
/// for what is alive at its beginning, an ordered map for what begins later).
struct Placed {
    leaves: usize,
    /// The stretches of the blocks that are alive in all of a node's time, in ascending order.
    alive: Vec<Vec<(u64, u64)>>,
    /// The stretches of blocks by their first batch.
    starts: BTreeMap<(usize, usize), (u64, u64)>,
}

impl Placed {
    fn new(batches: usize) -> Self {
        let leaves = batches.next_power_of_two();
        Self { leaves, alive: vec![Vec::new(); 2 * leaves], starts: BTreeMap::new() }
    }

    fn insert(&mut self, stretch: (u64, u64), at: usize, life: Range<usize>) {
        self.starts.insert((life.start, at), stretch);
        let (mut low, mut high) = (life.start + self.leaves, life.end + self.leaves);
        while low < high {
            if low % 2 == 1 {
                insert_sorted(&mut self.alive[low], stretch);
                low += 1;
            }
            if high % 2 == 1 {
                high -= 1;
                insert_sorted(&mut self.alive[high], stretch);
            }
            low /= 2;
            high /= 2;
        }
    }

    fn overlapping(&self, first: usize, last: usize) -> impl Iterator<Item = (u64, u64)> + '_ {
        let nodes =
            std::iter::successors(Some(first + self.leaves), |node| Some(node / 2)).take_while(|node| *node > 0);
        let later = self.starts.range((first + 1, 0)..(last + 1, 0)).map(|(_, stretch)| *stretch);
        nodes.flat_map(|node| &self.alive[node]).copied().chain(later)
    }
}

fn insert_sorted(stretches: &mut Vec<(u64, u64)>, stretch: (u64, u64)) {
    stretches.insert(stretches.partition_point(|other| *other < stretch), stretch);
}
