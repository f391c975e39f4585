//! Histogram: the distribution of luminance in an image.

use afterimage_graph::prelude::*;

use crate::metering::{HIGHEST_LOG2, LOWEST_LOG2, MeteringWeight, image_or_nothing, sampled, stride};

static SHADER: Shader = shader!("histogram");

node_kind! {
    /// Counts the pixels of each luminance, that of their channels above 0, in bins of equal width in stops.
    ///
    /// Every pixel is counted once. Bin 0 holds the pixels that the meter ignores: those at or below `black`, and those
    /// that the albedo's alpha excludes. Of a pixel that is nearly as dark as `black` it holds a part, so that a meter
    /// does not jump there. Pixels outside of the range count in the first or the last of the other bins. So the sum of
    /// all bins is the weight of the whole image. Counts are integers, so equal images give equal histograms.
    ///
    /// The default range is EV100 -10 to 19 for luminance in cd/m2, up to the largest half float. For brighter light,
    /// give the input a factor in the pipeline file, `Color(scale: 0.001)`.
    ///
    /// With `albedo` wired, the meter measures illumination and not reflected light: each pixel counts as a gray card
    /// of 18 % in the same light, 0.18 L / albedo (Lambert), with the albedo's luminance limited to 0.04 to 1. Without
    /// it, the mean reflectance of the scene is assumed to be 18 %.
    ///
    /// The table holds four floats, which are also the value `brightest`, and then the bins as integers. A full weight
    /// is min(255, (2^32 - 1) / pixels), so that no bin can overflow: 255 up to 16.8 million pixels, 129 at 7680x4320,
    /// 15 at 16384x16384.
    pub struct Histogram {
        /// Number of bins, including bin 0. Fewer are less accurate, not faster. The default has 13.2 bins per stop.
        pub bins: u32 = 384 => within(64.0..=512.0), quality(384u32, [192, 96]);
        /// Lower end of the range. -13 is EV100 -10, the default lower limit of `AutoExposure`.
        pub lo: f32 = LOWEST_LOG2 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Upper end of the range. 16 is EV100 19, the default upper limit of `AutoExposure`.
        pub hi: f32 = HIGHEST_LOG2 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Luminance at or below this does not count. A little above it a pixel counts in part: up to twice of it, and
        /// at least up to the lower end of the range above it. 0 excludes borders without a picture.
        pub black: f32 = 0.0 => within(0.0..=65504.0), usually(0.0..=0.01), unit("luminance");
        /// Sampling stride: 1 reads every pixel, 2 one of 2x2 squares of 4x4 pixels, chosen by a hash of their place.
        /// At least 900,000 pixels are read: in small images the stride is less. Pixels are skipped and not averaged,
        /// because a mean of light before the logarithm is too bright. When a picture of lines moves by a pixel, the
        /// exposure changes by at most 0.05 stops.
        pub step: u32 = 1 => within(1.0..=8.0), quality(1u32, [2, 4]);
        /// The weight of each pixel. A wired `mask` multiplies it.
        pub weight: MeteringWeight = MeteringWeight::Uniform;
        /// For `Center` and `Spot`: the position of full weight.
        pub center: [f32; 2] = [0.5, 0.5]
            => within(-1.0..=2.0), unit("uv"), unless("weight", [MeteringWeight::Uniform]);
        /// For `Center`: the distance from `center` at which the weight is 1/2. For `Spot`: the radius of the spot. A
        /// spot without a pixel keeps the exposure.
        pub radius: f32 = 0.5
            => within(0.01..=16.0), usually(0.1..=2.0), unit("image heights"),
               unless("weight", [MeteringWeight::Uniform]);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image, before the exposure.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("albedo", "Diffuse albedo, linear; alpha 0 excludes a pixel: sky, lamps, metal.")
            .accepts(&[ColorState::Data, ColorState::Scene])
            .optional(),
        Input::image("mask", "The weight of each pixel, 0 to 1, in red.")
            .accepts(&[ColorState::Data, ColorState::Scene])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] = &[
        Output::new("result", PortType::Table, OutputState::Nothing, "The range and the bins.").content("histogram"),
        Output::new(
            "brightest",
            PortType::Value,
            OutputState::Nothing,
            "x: the largest channel of all counted pixels; y, z: the range in log2; w: the number of bins.",
        )
        .content("brightest"),
    ];
}

/// Number of floats before the bins.
const HEADER: u64 = 4;
/// Width of a workgroup's tile, in sampled pixels.
const COLUMNS: u32 = 64;

/// Height of a workgroup's tile, in sampled pixels. Taller tiles write to the table less often. Shorter tiles keep
/// concurrent reads closer in the cache, if the image fits. Pictures that are made in bands need few rows at a time.
fn rows(sampled: Size, step: u32) -> u32 {
    if sampled.texels() < 0x100_0000 { 64 } else { (128 / step).next_multiple_of(16) }
}

impl Histogram {
    /// The count of a pixel with full weight.
    fn full_weight(pixels: u64) -> f32 {
        (u64::from(u32::MAX) / pixels).clamp(1, 255) as f32
    }

    /// The inverse of the luminance above `black` at which a pixel counts in full.
    fn rise(&self) -> f32 {
        self.black.max(self.lo.exp2()).recip()
    }
}

impl Node for Histogram {
    fn verify(&self) -> Result<(), String> {
        if self.lo < self.hi { Ok(()) } else { Err("`hi` must be above `lo`".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let step = stride(size, self.step);
        let sampled = sampled(size, step);
        let (albedo, mask) = (pass.wired("albedo"), pass.wired("mask"));
        let albedo_image = image_or_nothing(pass, "albedo");
        let mask_image = image_or_nothing(pass, "mask");
        // Whole vectors, because the header is also read as one.
        let bytes = (4 * (HEADER + u64::from(self.bins))).next_multiple_of(16);
        let table = pass.output_table("result", bytes, BufferLife::Zeroed);
        pass.set_output("brightest", InputValue::Buffer(table));
        let rows = rows(sampled, step);
        pass.compute(&SHADER, "histogram")
            .image("albedo", albedo_image)
            .image("mask", mask_image)
            .buffer("result", table)
            .set("bins_per_stop", f64::from(self.bins - 1) / f64::from(self.hi - self.lo))
            .set("rise", self.rise())
            .set("full_weight", Self::full_weight(sampled.texels()))
            .constant("HISTOGRAM_STEP", f64::from(step))
            .stride(step)
            .constant("HISTOGRAM_ALBEDO", f64::from(u8::from(albedo)))
            .constant("HISTOGRAM_MASK", f64::from(u8::from(mask)))
            .constant("HISTOGRAM_WEIGHT", self.weight.constant())
            .constant("HISTOGRAM_ROWS", f64::from(rows))
            .dispatch([sampled.width.div_ceil(COLUMNS), sampled.height.div_ceil(rows), 1]);
    }
}
