//! The cost model of tiles. Its figures were measured on an H200 (`graph/docs/performance.md`).

use afterimage_graph::node::{KernelCall, Pass};

/// What a dispatch costs however little it does, in nanoseconds.
const DISPATCH_NS: f64 = 2000.0;
/// What one byte through memory costs.
const BYTE_NS: f64 = 0.00037;
/// What one texel costs that is read through the device's filter, with all units busy.
const TEXTURE_READ_NS: f64 = 0.0007;
/// What one texel costs that is read from a tile: it must be found, unpacked and filtered in the shader.
const TILE_READ_NS: f64 = 0.0024;
/// What one read costs a workgroup whose latency no other workgroup hides.
const LONE_READ_NS: f64 = 30.0;
/// Invocations of a workgroup.
pub(super) const INVOCATIONS: f64 = 256.0;

/// What a pass costs in a dispatch of its own.
pub(super) fn separate_cost(pass: &Pass, texels: u64, moved: u64) -> f64 {
    DISPATCH_NS + (texels as f64 * weight(pass) * TEXTURE_READ_NS).max(moved as f64 * BYTE_NS)
}

/// What the members of a chain cost together, added up.
#[derive(Default)]
pub(super) struct JoinedCost {
    reads: f64,
    lone: f64,
    /// Bytes that go through memory.
    moved: u64,
}

impl JoinedCost {
    /// Adds a member of which each workgroup makes `extent` texels, from the tile before or from textures.
    pub(super) fn add(&mut self, pass: &Pass, extent: [u32; 2], groups: u64, from_tile: bool) {
        let texels = f64::from(extent[0]) * f64::from(extent[1]);
        let read = if from_tile { TILE_READ_NS } else { TEXTURE_READ_NS };
        self.reads += texels * groups as f64 * weight(pass) * read;
        self.lone += (texels / INVOCATIONS).ceil() * weight(pass) * LONE_READ_NS;
    }

    /// Adds bytes that go through memory.
    pub(super) fn add_bytes(&mut self, bytes: u64) {
        self.moved += bytes;
    }

    /// Nanoseconds of the one dispatch.
    pub(super) fn total(&self) -> f64 {
        DISPATCH_NS + self.reads.max(self.moved as f64 * BYTE_NS).max(self.lone)
    }
}

/// Texels that a texel of this pass reads, roughly.
fn weight(pass: &Pass) -> f64 {
    let one = |kernel: &KernelCall| {
        let taps = kernel.reach.map_or(4.0, |reach| (2.0 * f64::from(reach) + 2.0).powi(2));
        if kernel.reads_texture() { taps } else { 2.0 }
    };
    pass.kernels.iter().map(one).sum()
}
