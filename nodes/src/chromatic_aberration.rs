//! ChromaticAberration: colored fringes toward the corners.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("chromatic_aberration");

node_kind! {
    /// Moves red and blue outwards or inwards, so that edges far from the center have colored fringes.
    ///
    /// A lens magnifies colors differently (lateral chromatic aberration). A channel of the pixel at a place p from
    /// the center is that of the source at p / (1 + amount m s): m is `red` or `blue`, and s is 1 or, by `growth`, the
    /// square of the distance, which is 1 at the corners. Green stays. Alpha is the mean of those of the channels.
    /// It is a warp: with a `LensDistortion` before or after it, it is one pass, which reads each image three times.
    /// Beyond the border the border is read.
    pub struct ChromaticAberration {
        /// Factor of the effect. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=4.0), usually(0.0..=1.0), neutral(0.0);
        /// The magnification of red in the corners, less 1.
        pub red: f32 = 0.003 => within(-0.1..=0.1), usually(-0.01..=0.01), neutral(0.0);
        /// The magnification of blue in the corners, less 1.
        pub blue: f32 = -0.003 => within(-0.1..=0.1), usually(-0.01..=0.01), neutral(0.0);
        /// 0 for the same magnification everywhere, 1 for one that grows with the square of the distance, so that the
        /// middle of the image stays sharp.
        pub growth: f32 = 0.5 => within(0.0..=1.0);
        /// The optical center, from the center of the image.
        pub center: [f32; 2] = [0.0, 0.0] => within(-0.5..=0.5), unit("uv");
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, best before the tone curve.").accepts(&[
        ColorState::Scene,
        ColorState::Exposed,
        ColorState::DisplayLinear,
        ColorState::Encoded,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with fringes.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { symmetric: false, keeps_constant: true, ..Invariants::DEFAULT };
}

impl Node for ChromaticAberration {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.amount == 0.0 || self.red == 0.0 && self.blue == 0.0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let places = ["chromatic_aberration_red", "chromatic_aberration_green", "chromatic_aberration_blue"];
        pass.warp_channels(&SHADER, places, source).label("chromatic_aberration").write("result", desc);
    }
}
