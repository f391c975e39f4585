//! Vignette: darkens the image toward its corners.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("vignette");

node_kind! {
    /// Darkens the image toward its corners, as a lens does, or around any point.
    ///
    /// The factor falls from 1 to 0 by a Hermite step over a ring. The outer radius of the ring is 0.5 in uv. An
    /// intensity of 0 still darkens the corners: `amount` 0 switches the effect off. In optics a vignette belongs
    /// before the tone curve. After it, it is a look. Both are allowed.
    pub struct Vignette {
        /// Share of the effect. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// How far the darkening reaches inwards: distances from the center are multiplied by 1 + intensity.
        pub intensity: f32 = 0.0 => within(-1.0..=8.0), usually(0.0..=1.0);
        /// Width of the ring in which the light falls. 0 is a hard edge.
        pub smoothness: f32 = 0.3 => within(0.0..=1.0), unit("uv");
        /// 0 for a ring with the image's aspect ratio, 1 for a circle.
        pub roundness: f32 = 0.0 => within(0.0..=1.0);
        /// The middle of the ring.
        pub center: [f32; 2] = [0.5, 0.5] => within(-1.0..=2.0), usually(0.0..=1.0), unit("uv");
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, before or after the tone curve.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The darkened image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for Vignette {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let stretch = 1.0 + (desc.size.aspect() as f32 - 1.0) * self.roundness;
        pass.function(&SHADER, "vignette").set("stretch", stretch).write("result", desc);
    }
}
