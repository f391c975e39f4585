//! Dither: quantisation with noise against banding.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("dither");

params! {
    /// Quantises an encoded image to the codes of a file or a display, with noise against banding.
    ///
    /// The noise has a triangular distribution, so neither the mean nor the variance of the error depends on the image.
    /// It fades within half a code of black and white, so that solid black and white stay solid. The results are exact
    /// codes: any later rounding keeps them. Use it as the last node. Do not use it where the target stores floats.
    /// Equal seeds and frames give equal noise on every device.
    pub struct Dither {
        /// Bits per channel of the file or the display.
        pub bits: u32 = 8 => within(1.0..=12.0), usually(8.0..=10.0), unit("bits"), live();
        /// Whether each frame has different noise: less visible in motion, but harder to compress as video.
        pub animate: bool = false;
        /// Selects the noise.
        pub seed: u32 = 0 => within(0.0..=65535.0), live();
    }
}

impl Node for Dither {
    const INPUTS: &'static [Input] = &[Input::image("source", "The encoded image.").accepts(&[ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image in exact codes, 0 to 1.")];
    const FALLBACK: Fallback = Fallback::input("source");

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = if self.animate { "dither_animated" } else { "dither" };
        pass.function(&SHADER, kernel).write("result", desc);
    }
}
