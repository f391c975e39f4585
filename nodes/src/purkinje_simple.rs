//! PurkinjeSimple: a night look.

use afterimage_graph::prelude::*;

use crate::purkinje::{INPUTS, has_no_effect};

static SHADER: Shader = shader!("purkinje_simple");

node_kind! {
    /// A night look: less saturation, more blue, less red and more brightness as the light fades.
    ///
    /// It is the identity at 10 lux and above. Saturation falls by up to 70 % below 10 lux, blue and red move by up to
    /// 30 % toward 1.2 and 0.9 times the luminance below 5 lux, and up to half of the luminance is added below 1 lux.
    /// Each ramp is a Hermite step. It costs about a third of `Purkinje` and is a different look, not an approximation
    /// of it. It expects exposed light before any tone curve.
    pub struct PurkinjeSimple {
        /// Illuminance of the scene, if `meter` is not wired. 10 and more changes nothing.
        pub illuminance: f32 = 0.1
            => within(0.0..=100000.0), usually(0.0..=10.0), unit("lux"), neutral(10.0), when_wired("meter", false);
        /// Share of the effect. 0 changes nothing.
        pub strength: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
    }

    const INPUTS: &'static [Input] = INPUTS;
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with the night look.").or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

/// A Hermite step that is 1 at `lo` lux and below, and 0 at `hi` lux and above.
fn fading(lo: f64, hi: f64, lux: f32) -> f64 {
    let t = ((hi - f64::from(lux)) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Node for PurkinjeSimple {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        has_no_effect(self.strength, self.illuminance, inputs)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let function = if pass.wired("meter") { "purkinje_simple_metered" } else { "purkinje_simple" };
        let (lux, strength) = (self.illuminance, f64::from(self.strength));
        pass.function(&SHADER, function)
            .set("gray", 0.7 * strength * fading(0.01, 10.0, lux))
            .set("blue", 0.3 * strength * fading(0.01, 5.0, lux))
            .set("boost", 0.5 * strength * fading(0.001, 1.0, lux))
            .write("result", desc);
    }
}
