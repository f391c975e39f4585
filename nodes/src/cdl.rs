//! Cdl: the colour decision list of the American Society of Cinematographers.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("cdl");

params! {
    /// A colour decision list of the ASC: slope, offset, power and saturation, as cameras and grading programs exchange them.
    ///
    /// `(source * slope + offset)^power`, then away from or towards the grey of the same luminance. Values that are not positive skip the
    /// power and may stay below 0. With every parameter at its neutral value the node is left out.
    pub struct Cdl {
        /// Multiplies.
        pub slope: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Added.
        pub offset: [f32; 3] = [0.0, 0.0, 0.0] => within(-4.0..=4.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// The exponent: below 1 brightens the middle, above 1 darkens it.
        pub power: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// 0 is grey, 1 changes nothing.
        pub saturation: f32 = 1.0 => within(0.0..=4.0), usually(0.0..=2.0), neutral(1.0);
    }
}

impl Node for Cdl {
    const INPUTS: &'static [Input] = &[Input::image("source", "The picture, in the state that the list was made for.")
        .accepts(&[ColorState::Exposed, ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::Same("source"), "The graded picture.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        let neutral =
            self.slope == [1.0; 3] && self.offset == [0.0; 3] && self.power == [1.0; 3] && self.saturation == 1.0;
        neutral.then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&SHADER, "cdl").write("result", desc);
    }
}
