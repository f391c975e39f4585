//! Sharpen: an unsharp mask without halos.

use afterimage_graph::prelude::*;

use crate::gaussian::{Blur, GaussianKernel, GaussianTaps};

static SHADER: Shader = shader!("sharpen");

node_kind! {
    /// Sharpens an image by an unsharp mask: adds what a blur removes.
    ///
    /// The result stays within the range of the 3x3 pixels around each pixel, and `halo` widens that range: so edges
    /// get steeper without a bright and a dark line along them. Alpha passes unchanged. Light that was not negative
    /// does not become negative, and images for a display do not rise above 1 where they were below.
    pub struct Sharpen {
        /// Factor of the detail that is added. 0 changes nothing.
        pub amount: f32 = 0.5 => within(0.0..=8.0), usually(0.0..=2.0), neutral(0.0);
        /// Standard deviation of the blur: the size of the detail.
        pub radius: f32 = 1.0 => within(0.0..=16.0), usually(0.5..=4.0), unit("pixels");
        /// Detail that is smaller stays as it is, and larger detail is added less this much, so that noise is not
        /// sharpened.
        pub threshold: f32 = 0.0 => within(0.0..=65504.0), usually(0.0..=0.1);
        /// How far the result may leave the range of the pixels around it, as a share of that range. 0 is without
        /// halos.
        pub halo: f32 = 0.0 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, before or after the tone curve.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The sharper image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, ..Invariants::DEFAULT };
}

/// The blur ends at this many standard deviations.
const REACH: f32 = 3.0;

impl Node for Sharpen {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.amount == 0.0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let blurred = pass.transient("blurred", desc);
        Blur::new(GaussianKernel::Sigma, GaussianTaps::Exact, self.radius, REACH).record(pass, source, blurred);
        let is_linear = matches!(pass.color("source").state, ColorState::Scene | ColorState::Exposed);
        pass.function(&SHADER, "sharpen")
            .read("source", source)
            .read("blurred", blurred)
            .set("ceiling", if is_linear { 65504.0 } else { 1.0 })
            .write("result", desc);
    }
}
