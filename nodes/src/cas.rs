//! Cas: contrast adaptive sharpening.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("cas");

node_kind! {
    /// Sharpens an image for a display, less where there is much contrast already: contrast adaptive sharpening.
    ///
    /// Lottes, "FidelityFX CAS", AMD, 2019: each pixel minus a share of the four next to it, with a weight from the
    /// darkest and the brightest channel of the 3x3 pixels around it. Edges at black and at white get no halos. Made
    /// for images that temporal anti-aliasing has softened. In display-linear light it is as published; encoded images
    /// are sharpened more in the shadows. Alpha passes unchanged. Results are at least 0, and at most `white` where
    /// the pixel is.
    pub struct Cas {
        /// Share of the effect. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// The largest weight: a pixel loses 1/8 of each pixel next to it at 0, and 1/5 at 1, before the sum of the
        /// weights is made 1 again. At 0 the effect is weaker, but not off: that is `amount`.
        pub sharpness: f32 = 0.5 => within(0.0..=1.0);
        /// The white of the display, in the units of the image: 1 for SDR, the peak for HDR. Pixels near light of twice
        /// that are not sharpened.
        pub white: f32 = 1.0 => within(0.5..=128.0), usually(1.0..=16.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, after the tone curve.")
        .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The sharper image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, ..Invariants::DEFAULT };
}

impl Node for Cas {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.amount == 0.0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&SHADER, "cas").read("source", source).write("result", desc);
    }
}
