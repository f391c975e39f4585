//! LiftGammaGain: the three wheels of a colourist.

use afterimage_graph::prelude::*;
use glam::DVec3;

use crate::color::LUMINANCE;

static SHADER: Shader = shader!("lift_gamma_gain");

/// Below it, 1 / gamma would be a cliff.
const LEAST_GAMMA: f32 = 1e-3;

choices! {
    /// What the lift fades with.
    pub enum LiftBy {
        /// The luminance after the gain: hues stay.
        Luminance,
        /// Each channel before the gain: black becomes gain times lift, white becomes gain.
        Channel,
    }
}

params! {
    /// Moves black, bends the middle and scales white, for each channel.
    ///
    /// Gain multiplies, lift is added where the picture is dark, and the result is raised to 1/gamma. Values below 0 become 0 before the
    /// power. Meant for 0 to 1; brighter light is not lifted. With every parameter at its neutral value the node is left out.
    pub struct LiftGammaGain {
        /// What the lift fades with.
        pub lift_by: LiftBy = LiftBy::Luminance;
        /// Added to black; fades to nothing at white.
        pub lift: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.1..=0.1), neutral([0.0, 0.0, 0.0]);
        /// Above 1 brightens the middle, below 1 darkens it; black and white stay.
        pub gamma: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Multiplies.
        pub gain: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
    }
}

impl Node for LiftGammaGain {
    const INPUTS: &'static [Input] = &[Input::image("source", "The picture; best 0 to 1.").accepts(&[
        ColorState::Exposed,
        ColorState::DisplayLinear,
        ColorState::Encoded,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The graded picture, 0 or more.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        self.is_neutral().then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = match self.lift_by {
            LiftBy::Luminance => "lift_gamma_gain",
            LiftBy::Channel => "lift_gamma_gain_channels",
        };
        pass.function(&SHADER, kernel).set("power", self.power().to_array()).write("result", desc);
    }
}

impl LiftGammaGain {
    fn is_neutral(&self) -> bool {
        self.lift == [0.0; 3] && self.gamma == [1.0; 3] && self.gain == [1.0; 3]
    }

    fn power(&self) -> DVec3 {
        DVec3::from(self.gamma.map(|gamma| 1.0 / f64::from(gamma.max(LEAST_GAMMA))))
    }

    /// The same in double precision, with the lift by luminance: for baking.
    pub(crate) fn by_luminance(&self, rgb: DVec3) -> DVec3 {
        if self.is_neutral() {
            return rgb;
        }
        let [lift, gain] = [self.lift, self.gain].map(|v| DVec3::from(v.map(f64::from)));
        let gained = rgb * gain;
        let lifted = (gained + lift * (1.0 - LUMINANCE.dot(gained)).clamp(0.0, 1.0)).max(DVec3::ZERO);
        let power = self.power();
        DVec3::new(lifted.x.powf(power.x), lifted.y.powf(power.y), lifted.z.powf(power.z))
    }
}
