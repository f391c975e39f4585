//! GridBuild: a bilateral grid of a picture's luminance.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("grid_build");

choices! {
    /// How a pixel is put into the grid.
    pub enum GridBuildMethod {
        /// Into the one cell that it lies in: each pixel is read once. After the blur at most 0.03 stops from Trilinear.
        Nearest,
        /// Into the eight cells around it, by distance: each pixel is read by four workgroups.
        Trilinear,
    }
}

params! {
    /// Builds a bilateral grid (Chen, Paris and Durand, 2007): cells over x, y and log2 luminance that hold the sum of the luminance of
    /// the pixels in them and their number, divided by the number that a cell can take. Blurred by GridBlur it is an edge-aware blur, which
    /// LocalToneMap reads.
    ///
    /// One workgroup gathers one column of cells in whole numbers: no race, and the same grid in every run. The grid carries its own
    /// range, so its readers need not be told. `source` is an exposed picture, or the scene with `meter` and `stops` set as for the
    /// Exposure: then the exposed picture need not be stored.
    pub struct GridBuild {
        /// Cells across.
        pub width: u32 = 64 => within(4.0..=256.0), usually(16.0..=128.0), unit("cells");
        /// Cells down.
        pub height: u32 = 32 => within(4.0..=256.0), usually(8.0..=64.0), unit("cells");
        /// Cells of luminance.
        pub depth: u32 = 64 => within(4.0..=256.0), usually(16.0..=128.0), unit("cells");
        /// Where the range begins; darker pixels count as this. To the nearest 1/64. The default range has middle grey in its middle.
        pub lo: f32 = -10.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Where the range ends.
        pub hi: f32 = 5.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Stops to add to the picture's luminance; 0 for an exposed picture.
        pub stops: f32 = 0.0 => within(-24.0..=24.0), unit("stops"), neutral(0.0);
        /// How a pixel is put into the grid.
        pub method: GridBuildMethod =
            GridBuildMethod::Nearest => quality(GridBuildMethod::Trilinear, [GridBuildMethod::Nearest]);
        /// Looks at every pixel at 1, at every second of every second row at 2, and so on. What falls between them is missing in the grid.
        pub step: u32 = 1 => within(1.0..=8.0), quality(1u32, [2, 4]);
    }
}

/// What a full cell weighs: as much of the range of half floats as leaves room for 64 stops.
const FULL_CELL: f64 = 512.0;

/// The nearest of the numbers that halves hold exactly up to 32, so that readers find the very range that the grid was built with.
fn exact_in_half(x: f32) -> f32 {
    (x * 64.0).round() / 64.0
}

impl GridBuild {
    fn range(&self) -> [f32; 2] {
        [exact_in_half(self.lo), exact_in_half(self.hi)]
    }

    /// Pixels in a full cell, of those that are looked at.
    fn capacity(&self, picture: Size) -> u64 {
        let size = picture.div_up(self.step);
        u64::from(size.width.div_ceil(self.width)) * u64::from(size.height.div_ceil(self.height))
    }

    /// Steps of the fixed point in 1: the greatest power of two, up to 65536, with which no sum passes 2^32. A trilinear cell holds the weight
    /// of one cell's pixels, and another in doubt.
    fn unit(&self, capacity: u64) -> f64 {
        let [lo, hi] = self.range();
        let most = 2.0 * capacity as f64 * f64::from(hi - lo).max(1.0);
        (2.0_f64.powi(32) / most).log2().floor().clamp(0.0, 16.0).exp2()
    }
}

impl Node for GridBuild {
    const INPUTS: &'static [Input] = &[
        Input::image("source", "The exposed picture, or the scene with `meter`.")
            .accepts(&[ColorState::Exposed, ColorState::Scene]),
        Input::new("meter", PortType::Value, "Stops to add, in x: the result of a metering node.").optional(),
    ];
    const OUTPUTS: &'static [Output] = &[Output::new(
        "result",
        PortType::Volume,
        OutputState::Always(ColorState::Data),
        "Sums, weights and the range.",
    )];
    const FALLBACK: Fallback = Fallback::Absent;

    fn verify(&self) -> Result<(), String> {
        let [lo, hi] = self.range();
        if lo < hi { Ok(()) } else { Err("`hi` must be above `lo`, by 1/64 at least".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let capacity = self.capacity(pass.desc(source).size);
        let exposure =
            if pass.wired("meter") { pass.buffer("meter") } else { pass.constant_buffer("unmetered", vec![0; 16]) };
        let size = Size::volume(self.width, self.height, self.depth);
        let result = pass.output("result", ImageDesc::volume(size));
        let entry = match self.method {
            GridBuildMethod::Nearest => "grid_build_nearest",
            GridBuildMethod::Trilinear => "grid_build_trilinear",
        };
        let ([lo, hi], unit) = (self.range(), self.unit(capacity));
        let cells = [self.width, self.height];
        let by_cells = ByCells { form: "grid_build", source: "source", cells, together: 1, step: self.step };
        pass.compute(&SHADER, entry)
            .by_cells((self.method == GridBuildMethod::Nearest).then_some(by_cells))
            .buffer("exposure", exposure)
            .image("result", result)
            .set("lo", lo)
            .set("hi", hi)
            .set("size", [self.width, self.height, self.depth])
            .set("bins_per_stop", self.depth as f32 / (hi - lo))
            .set("unit", unit)
            .set("share", FULL_CELL / (unit * capacity as f64))
            .dispatch([self.width, self.height, 1]);
    }
}
