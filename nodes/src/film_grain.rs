//! FilmGrain: the texture of film.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("film_grain");

params! {
    /// Adds the grain of film: random, but the same on every device for the same seed and frame.
    ///
    /// The grain is strongest in the midtones and vanishes at black and white, so neither is ever touched and nothing is cut off; the mean
    /// of a flat area stays. It looks most like film on an encoded picture; on linear light, set `pivot` to 0.18. Put it before `Dither`.
    pub struct FilmGrain {
        /// How strong the grain is: 1 is as strong as the room to black and white allows; 0 leaves the picture as it is.
        pub amount: f32 = 0.15 => within(0.0..=1.0), usually(0.0..=0.4), neutral(0.0);
        /// How large a grain is; 1 is a grain to a pixel.
        pub size: f32 = 1.5 => within(1.0..=64.0), usually(1.0..=4.0), unit("px");
        /// 0 for grain of silver (all channels alike), 1 for that of three dyes (each its own).
        pub color: f32 = 0.3 => within(0.0..=1.0);
        /// The grain's strength in the deepest shadows, relative to the midtones.
        pub shadows: f32 = 0.8 => within(0.0..=1.0);
        /// The grain's strength in the brightest lights, relative to the midtones.
        pub highlights: f32 = 0.4 => within(0.0..=1.0);
        /// The luminance of the midtones: 0.5 on an encoded picture, 0.18 on linear light.
        pub pivot: f32 = 0.5 => within(0.01..=0.99);
        /// Whether every frame has grain of its own, as film has.
        pub animate: bool = true;
        /// Chooses the grain.
        pub seed: u32 = 0 => within(0.0..=65535.0), live();
    }
}

impl Node for FilmGrain {
    const INPUTS: &'static [Input] = &[Input::image("source", "The picture after the tone curve.")
        .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The picture with grain.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        (self.amount == 0.0).then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = if self.animate { "film_grain_animated" } else { "film_grain" };
        pass.function(&SHADER, kernel).write("result", desc);
    }
}
