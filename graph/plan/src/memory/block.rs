//! The blocks that placement packs: images as boxes of bytes and batches.

/// An image as the placement sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) bytes: u64,
    /// Alignment of its offset; a power of two.
    pub(crate) alignment: u64,
    /// The first batch of its life.
    pub(crate) first: usize,
    /// The last batch of its life.
    pub(crate) last: usize,
}

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
    let mut steps = vec![0_i64; batches + 1];
    for block in blocks {
        steps[block.first] += block.bytes as i64;
        steps[block.last + 1] -= block.bytes as i64;
    }
    let (mut alive, mut most) = (0, 0);
    for step in steps {
        alive += step;
        most = most.max(alive);
    }
    most as u64
}
