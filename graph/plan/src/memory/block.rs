//! What placement works on: images are rectangles, as high as their bytes and as long as their lives.

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
