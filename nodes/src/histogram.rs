//! Histogram: how often each luminance occurs in a picture.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("histogram");

choices! {
    /// How much each pixel counts.
    pub enum HistogramWeight {
        /// All the same.
        Uniform,
        /// Less the further it is from `center`, by a Gaussian.
        Center,
    }
}

params! {
    /// Counts the pixels of each luminance in bins of equal width in stops.
    ///
    /// Every pixel is counted once, by its full weight: bin 0 takes those that the meter leaves out (at or below `black`, or told not to
    /// count by the albedo's alpha), the first and the last of the other bins those beyond the range. So the bins always sum to the
    /// weight of the whole picture. Counts are whole numbers: a picture has the same histogram in every run.
    ///
    /// With `albedo` wired the meter sees light instead of paint: each pixel counts as a grey card of 18 % in the same light would,
    /// 0.18 L / albedo (Lambert), with the albedo's luminance kept within 0.04 and 1. Without it the reflectance of the scene is taken
    /// to be 18 % on average.
    ///
    /// The table is four floats, which are also the value `brightest`, and then the bins as whole numbers. Weights are 1 for plain
    /// metering. For weighted metering a full weight is min(255, (2^32 - 1) / pixels) steps, so that no bin can overflow: 255 up to
    /// 16.8 million pixels, 129 at 7680x4320, 15 at 16384x16384.
    pub struct Histogram {
        /// Bins, with bin 0. Fewer are coarser, not faster: 256 are off by 2e-5 stops, 128 by 6e-4, 64 by 4e-3.
        pub bins: u32 = 256 => within(64.0..=256.0), quality(256u32, [128, 64]);
        /// Where the first bin begins.
        pub lo: f32 = -10.0 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Where the last bin ends.
        pub hi: f32 = 10.0 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Luminance at and below this is left out. The default is 2^-10, where the range begins; 0 leaves out only true black.
        pub black: f32 = 0.0009765625 => within(0.0..=65504.0), usually(0.0..=0.01), unit("luminance");
        /// Counts every pixel at 1, every second of every second row at 2, and so on. Pixels are picked and not averaged, because
        /// an average of light before the logarithm is too bright. About 0.006 stops off at 2 and 0.021 at 4.
        pub step: u32 = 1 => within(1.0..=8.0), quality(1u32, [2, 4]);
        /// How much each pixel counts; a wired `mask` multiplies it.
        pub weight: HistogramWeight = HistogramWeight::Uniform;
        /// The middle for weight Center.
        pub center: [f32; 2] = [0.5, 0.5] => within(-1.0..=2.0), unit("uv");
        /// Where weight Center has fallen to a half, from the middle.
        pub radius: f32 = 0.5 => within(0.01..=16.0), usually(0.1..=2.0), unit("picture heights");
    }
}

/// Floats before the bins.
const HEADER: u64 = 4;
/// How wide a workgroup's tile is, in counted pixels.
const COLUMNS: u32 = 64;

/// Rows of a workgroup's tile: more leave the table alone for longer, fewer keep together in the cache what is read at the same time, where a
/// picture does fit.
fn rows(picked: Size) -> u32 {
    if picked.texels() < 0x100_0000 { 64 } else { 128 }
}

impl Histogram {
    /// What a pixel of full weight counts for.
    fn full_weight(&self, weighted: bool, pixels: u64) -> f32 {
        if weighted { (u64::from(u32::MAX) / pixels).clamp(1, 255) as f32 } else { 1.0 }
    }

    fn image_or_nothing(pass: &mut Recorder<'_>, port: &str) -> ImageId {
        if pass.wired(port) {
            return pass.image(port);
        }
        pass.constant("nothing", ImageDesc::new(Size::new(1, 1)), vec![0; 8])
    }
}

impl Node for Histogram {
    const INPUTS: &'static [Input] = &[
        Input::image("source", "The picture. Metering belongs before the exposure.")
            .accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("albedo", "Diffuse albedo, linear; alpha 0 where a pixel shall not count: sky, lamps, metal.")
            .accepts(&[ColorState::Data, ColorState::Scene])
            .optional(),
        Input::image("mask", "How much each pixel counts, 0 to 1, in red.")
            .accepts(&[ColorState::Data, ColorState::Scene])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] = &[
        Output::new("result", PortType::Table, OutputState::Nothing, "The range and the bins."),
        Output::new(
            "brightest",
            PortType::Value,
            OutputState::Nothing,
            "x: the largest channel of the pixels counted; y, z: the range in log2; w: the number of bins.",
        ),
    ];
    const FALLBACK: Fallback = Fallback::Absent;

    fn verify(&self) -> Result<(), String> {
        if self.lo < self.hi { Ok(()) } else { Err("`hi` must be above `lo`".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let picked = size.div_up(self.step);
        let (albedo, mask) = (pass.wired("albedo"), pass.wired("mask"));
        let center = self.weight == HistogramWeight::Center;
        let albedo_image = Self::image_or_nothing(pass, "albedo");
        let mask_image = Self::image_or_nothing(pass, "mask");
        // Whole vectors, because its beginning is also read as one.
        let bytes = (4 * (HEADER + u64::from(self.bins))).next_multiple_of(16);
        let table = pass.output_table("result", bytes, BufferLife::Zeroed);
        pass.give("brightest", Arrival::Buffer(table));
        let rows = rows(picked);
        pass.compute(&SHADER, "histogram")
            .image("albedo", albedo_image)
            .image("mask", mask_image)
            .buffer("result", table)
            .set("bins_per_stop", f64::from(self.bins - 1) / f64::from(self.hi - self.lo))
            .set("full_weight", self.full_weight(center || mask, picked.texels()))
            .constant("HISTOGRAM_ALBEDO", f64::from(u8::from(albedo)))
            .constant("HISTOGRAM_MASK", f64::from(u8::from(mask)))
            .constant("HISTOGRAM_CENTER", f64::from(u8::from(center)))
            .constant("HISTOGRAM_ROWS", f64::from(rows))
            .dispatch([picked.width.div_ceil(COLUMNS), picked.height.div_ceil(rows), 1]);
    }
}
