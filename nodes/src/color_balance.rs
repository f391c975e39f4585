//! ColorBalance: tints shadows, midtones and highlights.

use afterimage_graph::prelude::*;
use glam::DVec3;

use afterimage_color::adaptation::luminance_weights;

static SHADER: Shader = shader!("color_balance");

node_kind! {
    /// Tints shadows, midtones and highlights separately, and scales the channels.
    ///
    /// The channels are multiplied first. Then the shift of each range is added, with weights that depend on luminance
    /// y and overlap smoothly: (1-y)^2 for shadows, 2y(1-y) for midtones and y^2 for highlights. Their sum is 1, so
    /// equal shifts move the whole image.
    pub struct ColorBalance {
        /// Factor of each channel.
        pub multiply: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=4.0), usually(0.5..=1.5), neutral([1.0, 1.0, 1.0]);
        /// Added to shadows.
        pub shadows: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// Added to midtones.
        pub midtones: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// Added to highlights.
        pub highlights: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// Whether shifts keep luminance: the luminance that a shift would add is subtracted from it. Does not affect
        /// `multiply`.
        pub keep_luminance: bool = true => live();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image after the tone curve, preferably encoded.")
        .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The tinted image, 0 or more.").or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for ColorBalance {
    fn is_identity(&self, _: &InputValues) -> bool {
        let still = [self.shadows, self.midtones, self.highlights] == [[0.0; 3]; 3];
        still && self.multiply == [1.0; 3]
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let weights = luminance_weights(&pass.color("source").colorimetry.primaries);
        pass.function(&SHADER, "color_balance")
            .set("shadows", self.shift(self.shadows, weights))
            .set("midtones", self.shift(self.midtones, weights))
            .set("highlights", self.shift(self.highlights, weights))
            .set("luminance_weights", weights.to_array())
            .write("result", desc);
    }
}

impl ColorBalance {
    fn shift(&self, added: [f32; 3], weights: DVec3) -> [f64; 3] {
        let added = DVec3::from(added.map(f64::from));
        let light = if self.keep_luminance { weights.dot(added) } else { 0.0 };
        (added - light).to_array()
    }
}
