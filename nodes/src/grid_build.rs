//! GridBuild: a bilateral grid of an image's luminance.

use afterimage_graph::node::ComputePass;
use afterimage_graph::prelude::*;

use crate::metering::{EXPOSED_OR_METERED, sampled, stride};

static SHADER: Shader = shader!("grid_build");
static PARTS: Shader = shader!("grid_build_parts");

choices! {
    /// Filter from pixels to the grid.
    pub enum GridBuildMethod {
        /// To the cell that contains it: each pixel is read once. After local tone mapping with contrast 0.5 the
        /// error against `Trilinear` is at most 0.08 stops, at edges, and 0.0015 on average.
        Nearest,
        /// To the eight cells around it, with trilinear weights: each pixel is read by four workgroups.
        Trilinear,
    }
}

node_kind! {
    /// Builds a bilateral grid: cells over x, y and log2 luminance (Chen, Paris and Durand, 2007).
    ///
    /// A cell holds the sum of the log2 luminance of its pixels from the middle of the range, and their number, both
    /// divided by the capacity of a cell. After `GridBlur` it is an edge-aware blur, which `LocalToneMap` reads.
    ///
    /// Columns of cells are summed in integers, so there are no races and the grid is equal in every run.
    /// The grid stores its own range for its readers. `source` is an exposed image. It may also be the scene with
    /// `meter` and `stops` set as for the `Exposure`; then the exposed image need not be stored.
    pub struct GridBuild {
        /// Number of cells along x.
        pub width: u32 = 64 => within(4.0..=256.0), usually(16.0..=128.0), unit("cells");
        /// Number of cells along y.
        pub height: u32 = 32 => within(4.0..=256.0), usually(8.0..=64.0), unit("cells");
        /// Number of cells along luminance.
        pub depth: u32 = 64 => within(4.0..=256.0), usually(16.0..=128.0), unit("cells");
        /// Lower end of the range, rounded to 1/64. Darker pixels count as this. The default range has middle gray at
        /// its center.
        pub lo: f32 = -10.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Upper end of the range, rounded to 1/64. Brighter pixels count as this.
        pub hi: f32 = 5.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Stops added to the luminance of the image. 0 for an exposed image.
        pub stops: f32 = 0.0 => within(-24.0..=24.0), unit("stops"), neutral(0.0);
        /// How a pixel is added to the grid.
        pub method: GridBuildMethod =
            GridBuildMethod::Nearest => quality(GridBuildMethod::Trilinear, [GridBuildMethod::Nearest]);
        /// Sampling stride, as of `Histogram`. The other pixels are ignored.
        pub step: u32 = 1 => within(1.0..=8.0), quality(1u32, [2, 4]);
    }

    const INPUTS: &'static [Input] = &EXPOSED_OR_METERED;
    const OUTPUTS: &'static [Output] = &[Output::new(
        "result",
        PortType::Volume,
        OutputState::Always(ColorState::Data),
        "Sums, weights and the range.",
    )
    .content("bilateral-grid")];
}

/// The value of a full cell: as much of the range of half floats as leaves room for 64 stops.
const FULL_CELL: f64 = 512.0;

/// Rows of the tallest picture of which one workgroup sums a column of cells: every WebGPU device has textures of this
/// side, and taller pictures are made in bands on some. There each workgroup should need few rows at a time.
const TALL: u32 = 8192;
/// Rows of the parts of a column in taller pictures: about as many as of the parts that bands are made in.
const PART_ROWS: u32 = 128;

/// The nearest multiple of 1/64, which half floats hold exactly up to 32: readers get exactly the range of the grid.
fn exact_in_half(x: f32) -> f32 {
    (x * 64.0).round() / 64.0
}

impl GridBuild {
    fn range(&self) -> [f32; 2] {
        [exact_in_half(self.lo), exact_in_half(self.hi)]
    }

    /// The number of sampled pixels in a full cell.
    fn capacity(&self, picture: Size) -> u64 {
        let size = sampled(picture, stride(picture, self.step));
        u64::from(size.width.div_ceil(self.width)) * u64::from(size.height.div_ceil(self.height))
    }

    /// Workgroups that sum a column of cells. One is fastest.
    fn parts(&self, picture: Size) -> u32 {
        let is_tall = picture.height > TALL && self.method == GridBuildMethod::Nearest;
        if is_tall { picture.height.div_ceil(self.height).div_ceil(PART_ROWS) } else { 1 }
    }

    /// Steps of the fixed point per unit: the largest power of two, up to 65536, with which no sum exceeds 2^32. The
    /// bound allows for a trilinear cell with twice the weight of one cell's pixels.
    fn unit(&self, capacity: u64) -> f64 {
        let [lo, hi] = self.range();
        let most = 2.0 * capacity as f64 * f64::from(hi - lo).max(1.0);
        (2.0_f64.powi(32) / most).log2().floor().clamp(0.0, 16.0).exp2()
    }

    /// The factor from steps of the fixed point to stored values.
    fn share(&self, capacity: u64) -> f64 {
        FULL_CELL / (self.unit(capacity) * capacity as f64)
    }

    /// Sets the uniform of a kernel that reads pixels.
    fn set<'r, 'a>(&self, kernel: ComputePass<'r, 'a>, step: u32, capacity: u64) -> ComputePass<'r, 'a> {
        let [lo, hi] = self.range();
        kernel
            .constant("GRID_BUILD_STEP", f64::from(step))
            .stride(step)
            .set("lo", lo)
            .set("hi", hi)
            .set("size", [self.width, self.height, self.depth])
            .set("bins_per_stop", self.depth as f32 / (hi - lo))
            .set("unit", self.unit(capacity))
            .set("share", self.share(capacity))
    }
}

impl Node for GridBuild {
    fn verify(&self) -> Result<(), String> {
        let [lo, hi] = self.range();
        if lo < hi { Ok(()) } else { Err("`hi` must be above `lo` by at least 1/64".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let picture = pass.desc(source).size;
        let (step, capacity) = (stride(picture, self.step), self.capacity(picture));
        let exposure =
            if pass.wired("meter") { pass.buffer("meter") } else { pass.constant_buffer("unmetered", [0; 16]) };
        let size = Size::volume(self.width, self.height, self.depth);
        let result = pass.output("result", ImageDesc::volume(size));
        let ([lo, hi], parts) = (self.range(), self.parts(picture));
        if parts > 1 {
            let bytes = 8 * u64::from(self.width) * u64::from(self.height) * u64::from(self.depth);
            let sums = pass.add_buffer("sums", bytes, BufferLife::Zeroed);
            let kernel = pass.compute(&SHADER, "grid_build_part").buffer("exposure", exposure).buffer("sums", sums);
            let kernel = kernel.constant("GRID_BUILD_PARTS", f64::from(parts));
            self.set(kernel, step, capacity).dispatch([self.width, parts * self.height, 1]);
            return pass
                .compute(&PARTS, "grid_build_parts")
                .buffer("sums", sums)
                .image("result", result)
                .set("lo", lo)
                .set("hi", hi)
                .set("size", [self.width, self.height, self.depth])
                .set("share", self.share(capacity))
                .dispatch([self.width, self.height, 1]);
        }
        let entry = match self.method {
            GridBuildMethod::Nearest => "grid_build_nearest",
            GridBuildMethod::Trilinear => "grid_build_trilinear",
        };
        let kernel = pass.compute(&SHADER, entry).buffer("exposure", exposure).image("result", result);
        self.set(kernel, step, capacity).dispatch([self.width, self.height, 1]);
    }
}
