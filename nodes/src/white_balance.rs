//! WhiteBalance: changes the color of white by chromatic adaptation.

use afterimage_graph::color::Xy;
use afterimage_graph::prelude::*;
use glam::DMat3;

use afterimage_color::adaptation::{Cones, MIN_TARGET, light_of_gray, rows, white_from, white_to};

static SHADER: Shader = shader!("white_balance");

/// The temperature of D65 itself: the daylight formula at 6504 K differs by some 1e-4.
const NEUTRAL_KELVIN: f32 = 6500.0;

/// The largest `tint`.
const MAX_TINT: f64 = 0.05;
/// The channels of gray may differ by this part in an image of 16 bits.
const GRAY_SPREAD: f64 = 1e-3;

choices! {
    /// The meaning of the parameters.
    pub enum WhiteBalanceMode {
        /// `target` is the color that white becomes: a look.
        Target,
        /// `temperature` and `tint` are those of the scene's light, which becomes neutral: a correction.
        Temperature,
    }
}

node_kind! {
    /// Changes the color of white by scaling cone responses (Bradford or CAT16).
    ///
    /// Place it before the tone curve: after it, clipped highlights would be tinted. With a gray `target`, or with 6500
    /// K and no tint, the node is skipped. Saturated colors may leave the triangle of Rec.709: their
    /// channels become negative.
    pub struct WhiteBalance {
        /// Which parameters apply.
        pub mode: WhiteBalanceMode = WhiteBalanceMode::Target;
        /// The model of chromatic adaptation.
        pub adaptation: Cones = Cones::Bradford;
        /// For `Target`: the color that white becomes, in linear Rec.709. Components are raised to at least 0.0001.
        pub target: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.0..=1.0), neutral([1.0, 1.0, 1.0]);
        /// For `Target`: whether to use only the chromaticity of `target` and keep the luminance of white.
        pub keep_luminance: bool = true;
        /// For `Temperature`: the temperature of the scene's light. 3200 is a lamp, 10000 is open shade, 6500 is
        /// exactly D65. Up to 3333 K it is that of a black body, from 4000 K that of daylight, and a blend between.
        pub temperature: f32 = 6500.0
            => within(1667.0..=25000.0), usually(2500.0..=12000.0), unit("K"), neutral(6500.0);
        /// For `Temperature`: distance of the light from the locus of daylight and black bodies, positive toward
        /// green.
        pub tint: f32 = 0.0 => within(-0.05..=0.05), usually(-0.02..=0.02), unit("Duv"), neutral(0.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "Light before the tone curve.").accepts(&[ColorState::Scene, ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The balanced light.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for WhiteBalance {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.is_neutral()
    }

    fn values_for_gray(&self, color: [f64; 3]) -> Option<Vec<(&'static str, Value)>> {
        let is_near = |channel: &f64| (channel / color[1] - 1.0).abs() <= GRAY_SPREAD;
        let is_gray = color[1] > 0.0 && color.iter().all(is_near);
        let (kelvin, duv) = if is_gray { (NEUTRAL_KELVIN.into(), 0.0) } else { light_of_gray(color)? };
        // As many digits as keep gray within 16 bits.
        let (kelvin, duv) = ((kelvin * 10.0).round() / 10.0, (duv * 1e5).round() / 1e5);
        let kelvin = kelvin.clamp(1667.0, 25000.0);
        (duv.abs() <= MAX_TINT).then(|| {
            let mode = Value::Choice(WhiteBalanceMode::Temperature.name());
            vec![("mode", mode), ("temperature", Value::Float(kelvin)), ("tint", Value::Float(duv))]
        })
    }

    fn color(&self) -> ColorChange {
        match self.mode {
            WhiteBalanceMode::Target => ColorChange::Keep,
            WhiteBalanceMode::Temperature => ColorChange::Adapt(Xy::D65),
        }
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
    /// Tests the parameters and not the matrix, whose rounding would make the result arbitrary.
    fn is_neutral(&self) -> bool {
        match self.mode {
            WhiteBalanceMode::Target => {
                let [r, g, b] = self.target.map(|x| x.max(MIN_TARGET));
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
