//! Vignette: darkens the picture towards its corners.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("vignette");

params! {
    /// Darkens the picture towards its corners, as a lens does.
    ///
    /// The light that remains falls from 1 to 0 by a Hermite step over a ring whose outer radius is half of the picture's side, measured
    /// in uv. An intensity of 0 still darkens the corners: `amount` 0 is the way to switch it off. Optically a vignette belongs before the
    /// tone curve; after it, it is a look. Both are allowed.
    pub struct Vignette {
        /// Share of the effect that is mixed in; 0 leaves the picture as it is.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// How far the dark reaches inwards: distances from the middle are multiplied by 1 + intensity.
        pub intensity: f32 = 0.0 => within(-1.0..=8.0), usually(0.0..=1.0);
        /// Width of the ring in which the light falls; 0 is a hard edge.
        pub smoothness: f32 = 0.3 => within(0.0..=1.0), unit("uv");
        /// 0 for a ring that follows the picture's shape, 1 for a true circle.
        pub roundness: f32 = 0.0 => within(0.0..=1.0);
    }
}

impl Node for Vignette {
    const INPUTS: &'static [Input] = &[Input::image("source", "The picture, before or after the tone curve.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::Same("source"), "The darkened picture.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        (self.amount == 0.0).then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let stretch = 1.0 + (desc.size.aspect() as f32 - 1.0) * self.roundness;
        pass.function(&SHADER, "vignette").set("stretch", stretch).write("result", desc);
    }
}
