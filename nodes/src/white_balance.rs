//! WhiteBalance: changes the colour of white by chromatic adaptation.

use afterimage_graph::prelude::*;
use glam::DMat3;

use crate::color::{Cones, LEAST_TARGET, rows, white_from, white_to};

static SHADER: Shader = shader!("white_balance");

/// The temperature that stands for D65 itself: the daylight formula at 6504 K is some ten-thousandths off.
const NEUTRAL_KELVIN: f32 = 6500.0;

choices! {
    /// What the parameters of a white balance mean.
    pub enum WhiteBalanceMode {
        /// `target` is the colour that white becomes: a look.
        Target,
        /// `temperature` and `tint` are those of the scene's light, which becomes neutral: a correction.
        Temperature,
    }
}

params! {
    /// Changes the colour of white, by scaling the responses of the eye's cones (Bradford or CAT16).
    ///
    /// It belongs before the tone curve: after it, highlights that were cut off at white would be tinted. At `target` grey, and at 6500 K
    /// without tint, nothing changes and the node is left out. Saturated colours that leave the gamut end at black in the channel that would be negative.
    pub struct WhiteBalance {
        /// Which of the parameters count.
        pub mode: WhiteBalanceMode = WhiteBalanceMode::Target;
        /// The model of adaptation.
        pub adaptation: Cones = Cones::Bradford;
        /// For `Target`: what white becomes, in linear Rec.709. Components are raised to at least 0.0001.
        pub target: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.0..=1.0), neutral([1.0, 1.0, 1.0]);
        /// For `Target`: whether only the colour of `target` counts, and white stays as bright as it was.
        pub keep_luminance: bool = true;
        /// For `Temperature`: that of the scene's light; 3200 is a lamp, 10000 is open shade. 6500 is D65 exactly.
        pub temperature: f32 = 6500.0 => within(1667.0..=25000.0), usually(2500.0..=12000.0), unit("K"), neutral(6500.0);
        /// For `Temperature`: how far the light is off the locus of daylight and lamps, towards green if positive.
        pub tint: f32 = 0.0 => within(-0.05..=0.05), usually(-0.02..=0.02), unit("Duv"), neutral(0.0);
    }
}

impl Node for WhiteBalance {
    const INPUTS: &'static [Input] =
        &[Input::image("source", "Light before the tone curve.").accepts(&[ColorState::Scene, ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The balanced light, 0 or more.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        self.is_neutral().then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let [row0, row1, row2] = rows(self.matrix());
        pass.function(&SHADER, "white_balance")
            .set("row0", row0)
            .set("row1", row1)
            .set("row2", row2)
            .write("result", desc);
    }
}

impl WhiteBalance {
    /// By the parameters and not by the matrix, whose rounding would make the answer a matter of luck.
    fn is_neutral(&self) -> bool {
        match self.mode {
            WhiteBalanceMode::Target => {
                let [r, g, b] = self.target.map(|x| x.max(LEAST_TARGET));
                r == g && g == b && (self.keep_luminance || r == 1.0)
            }
            WhiteBalanceMode::Temperature => self.temperature == NEUTRAL_KELVIN && self.tint == 0.0,
        }
    }

    /// The matrix on linear Rec.709.
    pub(crate) fn matrix(&self) -> DMat3 {
        match self.mode {
            _ if self.is_neutral() => DMat3::IDENTITY,
            WhiteBalanceMode::Target => white_to(self.target, self.adaptation, self.keep_luminance),
            WhiteBalanceMode::Temperature => {
                white_from(f64::from(self.temperature), f64::from(self.tint), self.adaptation)
            }
        }
    }
}
