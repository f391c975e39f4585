//! Cdl: the colour decision list of the American Society of Cinematographers.

use afterimage_graph::prelude::*;

use crate::color::luminance_weights;

static SHADER: Shader = shader!("cdl");

params! {
    /// An ASC colour decision list: slope, offset, power and saturation, as cameras and grading programs exchange them.
    ///
    /// `(source * slope + offset)^power`, then `saturation` scales the distance from the grey of the same luminance.
    /// Values at or below 0 skip the power and may stay below 0. With every parameter at its neutral value the node is
    /// skipped.
    pub struct Cdl {
        /// Factor of each channel.
        pub slope: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Added to each channel after the slope.
        pub offset: [f32; 3] = [0.0, 0.0, 0.0] => within(-4.0..=4.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// Exponent of each channel. Below 1 brightens midtones, above 1 darkens them.
        pub power: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Factor of the distance from grey. 0 is grey, 1 changes nothing.
        pub saturation: f32 = 1.0 => within(0.0..=4.0), usually(0.0..=2.0), neutral(1.0);
    }
}

impl Node for Cdl {
    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image, in the color state that the list was made for.").accepts(&[
            ColorState::Exposed,
            ColorState::DisplayLinear,
            ColorState::Encoded,
        ])];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "The graded image.")];
    const FALLBACK: Fallback = Fallback::input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        let neutral =
            self.slope == [1.0; 3] && self.offset == [0.0; 3] && self.power == [1.0; 3] && self.saturation == 1.0;
        neutral.then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let weights = luminance_weights(&pass.color("source").colorimetry.primaries);
        pass.function(&SHADER, "cdl").set("luminance_weights", weights.to_array()).write("result", desc);
    }
}
