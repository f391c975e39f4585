//! MeanLuminance: the mean luminance of an image.

use afterimage_graph::prelude::*;

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

params! {
    /// Computes the mean luminance of an image as log2, in two passes at any size: the top of a luminance pyramid.
    ///
    /// It has no percentiles, so bright lights and black borders count in full. `Histogram` with `AutoExposure` is the
    /// better meter, this kind with `Adapt` the cheaper one. Each pixel counts once, and sums have a fixed order.
    ///
    /// The result is (log2 of the mean, brightest luminance, 0, 1 if any pixel is brighter than 2^lo).
    pub struct MeanLuminance {
        /// The kind of mean.
        pub mean: MeanLuminanceOf = MeanLuminanceOf::Log;
        /// Darker pixels count as this. It is also the lower limit of the result.
        pub lo: f32 = -10.0 => within(-24.0..=16.0), unit("log2 of luminance");
    }
}

/// Width and height of a workgroup's tile, in pixels.
const TILE: u32 = 64;

impl Node for MeanLuminance {
    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image, before the exposure.").accepts(&[ColorState::Scene, ColorState::Exposed])];
    const OUTPUTS: &'static [Output] = &[Output::new(
        "result",
        PortType::Value,
        OutputState::Nothing,
        "log2 of the mean, the brightest luminance, 0, and 1 if any pixel is brighter than 2^lo.",
    )];
    const FALLBACK: Fallback = Fallback::Absent;

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let groups = size.div_up(TILE);
        let tiles = groups.width * groups.height;
        let sums = pass.add_buffer("sums", 8 * u64::from(tiles), BufferLife::Frame);
        let result = pass.output_value("result", BufferLife::Frame);
        let (of_tiles, of_all) = match self.mean {
            MeanLuminanceOf::Log => ("mean_luminance_log", "mean_luminance_of_logs"),
            MeanLuminanceOf::Linear => ("mean_luminance_linear", "mean_luminance_log_of_mean"),
        };
        pass.compute(&SHADER, of_tiles)
            .image("picture", source)
            .buffer("written", sums)
            .set("pixels", size.texels() as f32)
            .set("tiles", tiles)
            .dispatch([groups.width, groups.height, 1]);
        pass.compute(&SHADER, of_all)
            .buffer("tiles", sums)
            .buffer("result", result)
            .set("pixels", size.texels() as f32)
            .set("tiles", tiles)
            .dispatch([1, 1, 1]);
    }
}
