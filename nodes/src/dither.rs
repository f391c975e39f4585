//! Dither: noise that makes up for the codes that a file or a screen does not have.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("dither");

params! {
    /// Rounds an encoded picture to the codes of a file or a screen, with noise that keeps smooth gradients from banding.
    ///
    /// The noise is triangular, so neither the mean nor the strength of the error depends on the picture; within half a code of black and
    /// white it fades, so that solid black and white stay solid. The result holds values that are codes already: any rounding behind it gives
    /// them. Put it last. Where the target holds floats, leave it out. Equal seeds and frames give equal noise on every device.
    pub struct Dither {
        /// Bits of a channel in the file or on the screen.
        pub bits: u32 = 8 => within(1.0..=12.0), usually(8.0..=10.0), unit("bits"), live();
        /// Whether every frame has noise of its own: calmer in motion, worse for video codecs.
        pub animate: bool = false;
        /// Chooses the noise.
        pub seed: u32 = 0 => within(0.0..=65535.0), live();
    }
}

impl Node for Dither {
    const INPUTS: &'static [Input] = &[Input::image("source", "The encoded picture.").accepts(&[ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Encoded), "The picture in whole codes, 0 to 1.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = if self.animate { "dither_animated" } else { "dither" };
        pass.function(&SHADER, kernel).write("result", desc);
    }
}
