//! FilmGrain: the grain of film.

use afterimage_graph::prelude::*;

use afterimage_color::adaptation::luminance_weights;

static SHADER: Shader = shader!("film_grain");

/// The tiles of `film_grain_tiles`, the second below the first.
const TILES: [u32; 2] = [256, 256 + 239];
/// Grain of fewer pixels is not made of tiles, which would cost more.
const MIN_TILED_PIXELS: u64 = 1 << 19;

node_kind! {
    /// Adds film grain: random, but equal on every device for equal seeds and frames.
    ///
    /// The grain is strongest in midtones and fades to zero at black and white, so it never clips. The mean of a flat
    /// area stays the same. Grains are round and have no grid: one in each square of `size`, at a random place. It
    /// looks most like film on an encoded image; on linear light, set `pivot` to 0.18. Place it before `Dither`.
    ///
    /// Images of half a megapixel or more get a mixture of two periodic tiles, of 256 and 239 pixels a side, which are
    /// made once. The mixture is another one at each place, so no tile repeats.
    pub struct FilmGrain {
        /// Strength of the grain. 1 is the largest amplitude that does not clip, 0 changes nothing.
        pub amount: f32 = 0.15 => within(0.0..=1.0), usually(0.0..=0.4), neutral(0.0);
        /// Diameter of a grain. 1 is one grain per pixel.
        pub size: f32 = 1.5 => within(1.0..=64.0), usually(1.0..=4.0), unit("px");
        /// The lines of the image that `size` is meant for, such as 1080: an image of twice as many has grains of twice
        /// the size, and looks the same. 0 for grains of `size` in any image.
        pub lines: f32 = 0.0 => within(0.0..=16384.0), usually(0.0..=4320.0), unit("px");
        /// 0 for monochrome grain (equal in all channels), 1 for color grain (independent channels). The strength in
        /// each channel is the same for all values.
        pub color: f32 = 0.3 => within(0.0..=1.0);
        /// Strength of the grain in the darkest shadows, relative to midtones.
        pub shadows: f32 = 0.8 => within(0.0..=1.0);
        /// Strength of the grain in the brightest highlights, relative to midtones.
        pub highlights: f32 = 0.4 => within(0.0..=1.0);
        /// Luminance of the midtones: 0.5 on an encoded image, 0.18 on linear light.
        pub pivot: f32 = 0.5 => within(0.01..=0.99);
        /// Whether each frame has different grain, as film has.
        pub animate: bool = true;
        /// Selects the grain.
        pub seed: u32 = 0 => within(0.0..=65535.0), live();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image after the tone curve.")
        .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with grain.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for FilmGrain {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let weights = luminance_weights(&pass.color("source").colorimetry.primaries).to_array();
        let lines = if self.lines > 0.0 { self.lines } else { desc.size.height as f32 };
        let size = (self.size * desc.size.height as f32 / lines).max(1.0);
        if desc.size.texels() < MIN_TILED_PIXELS {
            let kernel = if self.animate { "film_grain_animated" } else { "film_grain" };
            let pass = pass.function(&SHADER, kernel).set("size", size);
            pass.set("luminance_weights", weights).write("result", desc);
            return;
        }
        let tiles = pass.retained("tiles", ImageDesc::new(Size::new(TILES[0], TILES[1])));
        pass.function(&SHADER, "film_grain_tiles").set("size", size).write_to(tiles);
        let kernel = if self.animate { "film_grain_tiled_animated" } else { "film_grain_tiled" };
        let pass = pass.function(&SHADER, kernel).read("tiles", tiles).set("size", size);
        pass.set("luminance_weights", weights).write("result", desc);
    }
}
