//! MeanLuminance: the mean luminance of an image.

use afterimage_graph::prelude::*;

use crate::metering::{LOWEST_LOG2, MeteringWeight, image_or_nothing};

static SHADER: Shader = shader!("mean_luminance");

choices! {
    /// The kind of mean.
    pub enum MeanLuminanceOf {
        /// Of the logarithm: the brightness of a typical pixel.
        Log,
        /// Of light: the total amount of light. One lamp can outweigh a dark room by stops.
        Linear,
    }
}

node_kind! {
    /// Computes the mean luminance of an image as log2, in two passes at any size: the top of a luminance pyramid.
    ///
    /// It has no percentiles, so bright lights and black borders count in full. `Histogram` with `AutoExposure` is the
    /// better meter, this kind with `Adapt` the cheaper one. Each pixel counts once, with its weight. Sums have a fixed
    /// order.
    ///
    /// The result is (log2 of the mean, brightest luminance, 0, 1 if any pixel with a weight is brighter than black).
    pub struct MeanLuminance {
        /// The kind of mean.
        pub mean: MeanLuminanceOf = MeanLuminanceOf::Log;
        /// Darker pixels count as this. It is also the lower limit of the result.
        pub lo: f32 = LOWEST_LOG2 => within(-24.0..=16.0), unit("log2 of luminance");
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
        Input::image("mask", "The weight of each pixel, 0 to 1, in red.")
            .accepts(&[ColorState::Data, ColorState::Scene])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] = &[Output::new(
        "result",
        PortType::Value,
        OutputState::Nothing,
        "log2 of the mean, the brightest luminance, 0, and 1 if any pixel is brighter than black.",
    )
    .content("mean-luminance")];
}

/// Width and height of a workgroup's tile, in pixels.
const TILE: u32 = 64;

impl Node for MeanLuminance {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let groups = size.div_up(TILE);
        let tiles = groups.width * groups.height;
        let sums = pass.add_buffer("sums", 16 * u64::from(tiles), BufferLife::Frame);
        let result = pass.output_value("result", BufferLife::Frame);
        let (of_tiles, of_all) = match self.mean {
            MeanLuminanceOf::Log => ("mean_luminance_log", "mean_luminance_of_logs"),
            MeanLuminanceOf::Linear => ("mean_luminance_linear", "mean_luminance_log_of_mean"),
        };
        let mask = image_or_nothing(pass, "mask");
        let has_mask = pass.wired("mask");
        let weighted = f64::from(u8::from(has_mask || self.weight != MeteringWeight::Uniform));
        pass.compute(&SHADER, of_tiles)
            .image("picture", source)
            .image("mask", mask)
            .buffer("written", sums)
            .set("pixels", size.texels() as f32)
            .set("tiles", tiles)
            .constant("MEAN_LUMINANCE_WEIGHT", self.weight.constant())
            .constant("MEAN_LUMINANCE_MASK", f64::from(u8::from(has_mask)))
            .constant("MEAN_LUMINANCE_WEIGHTED", weighted)
            .dispatch([groups.width, groups.height, 1]);
        pass.compute(&SHADER, of_all)
            .buffer("tiles", sums)
            .buffer("result", result)
            .set("pixels", size.texels() as f32)
            .set("tiles", tiles)
            .constant("MEAN_LUMINANCE_WEIGHTED", weighted)
            .dispatch([1, 1, 1]);
    }
}
