//! LiftGammaGain: the three controls of color grading for shadows, midtones and highlights.

use afterimage_graph::prelude::*;
use glam::DVec3;

use afterimage_color::adaptation::luminance_weights;

static SHADER: Shader = shader!("lift_gamma_gain");

/// Lower limit of gamma: 1 / gamma grows without bound below it.
const MIN_GAMMA: f32 = 1e-3;

choices! {
    /// The quantity with which the lift fades.
    pub enum LiftBy {
        /// The luminance after the gain: hues stay the same.
        Luminance,
        /// Each channel before the gain: black becomes gain times lift, white becomes gain.
        Channel,
    }
}

node_kind! {
    /// Shifts black, bends midtones and scales white, for each channel.
    ///
    /// Gain is a factor. Lift is added where the image is dark. The result is raised to 1/gamma, after values below 0
    /// become 0. Intended for values of 0 to 1; brighter light gets no lift. With every parameter at its neutral value
    /// the node is skipped.
    pub struct LiftGammaGain {
        /// The quantity with which the lift fades.
        pub lift_by: LiftBy = LiftBy::Luminance;
        /// Added to black. Fades to zero at white.
        pub lift: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.1..=0.1), neutral([0.0, 0.0, 0.0]);
        /// Exponent 1/gamma. Above 1 brightens midtones, below 1 darkens them; black and white stay the same.
        pub gamma: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Factor of each channel.
        pub gain: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, preferably 0 to 1.").accepts(&[
        ColorState::Exposed,
        ColorState::DisplayLinear,
        ColorState::Encoded,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The graded image, 0 or more.").or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for LiftGammaGain {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.is_neutral()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = match self.lift_by {
            LiftBy::Luminance => "lift_gamma_gain",
            LiftBy::Channel => "lift_gamma_gain_channels",
        };
        let weights = luminance_weights(&pass.color("source").colorimetry.primaries);
        pass.function(&SHADER, kernel)
            .set("power", self.power().to_array())
            .set("luminance_weights", weights.to_array())
            .write("result", desc);
    }
}

impl LiftGammaGain {
    fn is_neutral(&self) -> bool {
        self.lift == [0.0; 3] && self.gamma == [1.0; 3] && self.gain == [1.0; 3]
    }

    fn power(&self) -> DVec3 {
        DVec3::from(self.gamma.map(|gamma| 1.0 / f64::from(gamma.max(MIN_GAMMA))))
    }
}
