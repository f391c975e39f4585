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

#[cfg(test)]
mod tests {
    use afterimage_graph::node::{Arg, ImageId, KernelCall};
    use afterimage_wgsl::Shader;

    use super::*;

    static SHADER: Shader = Shader::new("test", "");

    /// A pass of a kernel that reads a texture that far, and one that reads a pixel.
    fn pass(reach: Option<f32>) -> Pass {
        let around = KernelCall::function("node", &SHADER, "around", &[("source", Arg::Texture(ImageId(0)))]);
        let pixel = KernelCall::function("node", &SHADER, "pixel", &[("source", Arg::Kernel(0))]);
        let kernels = vec![KernelCall { reach, ..around }, pixel];
        Pass::of_functions(vec!["node".into()], "test".into(), kernels, ImageId(1))
    }

    fn close(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 1e-6 * wanted, "{found} and not {wanted}");
    }

    /// A kernel of reach 1 reads 16 texels, one of unknown reach 4, and a pixel counts 2.
    #[test]
    fn a_pass_alone_costs_a_dispatch_and_its_reads_or_its_bytes() {
        close(weight(&pass(Some(1.0))), 18.0);
        close(weight(&pass(Some(0.5))), 11.0);
        close(weight(&pass(None)), 6.0);
        close(separate_cost(&pass(Some(1.0)), 1_000_000, 0), 2000.0 + 18.0e6 * 0.0007);
        close(separate_cost(&pass(Some(1.0)), 1_000_000, 100_000_000), 2000.0 + 1.0e8 * 0.00037);
    }

    /// The largest of reads, bytes and latency, not their sum.
    #[test]
    fn a_chain_costs_a_dispatch_and_the_slowest_of_its_three_ways() {
        let mut reads = JoinedCost::default();
        reads.add(&pass(Some(1.0)), [20, 20], 10_000, false);
        close(reads.total(), 2000.0 + 400.0 * 10_000.0 * 18.0 * 0.0007);
        reads.add(&pass(Some(1.0)), [16, 16], 10_000, true);
        close(reads.total(), 2000.0 + 10_000.0 * 18.0 * (400.0 * 0.0007 + 256.0 * 0.0024));
        // 400 texels are two rounds of 256 invocations.
        let mut lone = JoinedCost::default();
        lone.add(&pass(Some(1.0)), [20, 20], 1, false);
        close(lone.total(), 2000.0 + 2.0 * 18.0 * 30.0);
        lone.add(&pass(None), [16, 16], 1, true);
        close(lone.total(), 2000.0 + (2.0 * 18.0 + 6.0) * 30.0);
        lone.add_bytes(50_000_000);
        lone.add_bytes(50_000_000);
        close(lone.total(), 2000.0 + 1.0e8 * 0.00037);
    }
}
