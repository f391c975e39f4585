//! Halation: the red glow around bright places on film.

use afterimage_graph::prelude::*;

use crate::gaussian::Blur;

static SHADER: Shader = shader!("halation");

node_kind! {
    /// Spreads a share of the light around bright places, most of the red: halation, as film without a backing has it.
    ///
    /// Light that passes the emulsion is reflected by the back of the film's base and exposes it again, from below:
    /// first the red layer. The share is taken from where the light arrived, so a constant image stays the same and the
    /// sum of all light, too; no threshold is needed, because only bright places have enough light to show. Place it
    /// before the tone curve. The glow is a Gaussian, made at a lower resolution for wide ones, where it is as much
    /// narrower as halvings and the enlargement widen it. Alpha is spread with the mean share of the channels.
    pub struct Halation {
        /// Share of the light that is spread, at most. 0 changes nothing.
        pub strength: f32 = 0.1 => within(0.0..=1.0), usually(0.0..=0.5), neutral(0.0);
        /// The shares of red, green and blue among it.
        pub tint: [f32; 3] = [1.0, 0.3, 0.08] => within(0.0..=1.0);
        /// Standard deviation of the glow, in heights of the image. On 35 mm film it is near 0.01.
        pub radius: f32 = 0.01 => within(0.0..=0.25), usually(0.0..=0.05), unit("heights"), replans();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, before the tone curve.").accepts(&[
        ColorState::Scene,
        ColorState::Exposed,
        ColorState::DisplayLinear,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with the glow.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, keeps_sum: true, ..Invariants::DEFAULT };
}

/// The widest blur that is made at one resolution, in texels. A wider one is made at half of it.
const WIDEST: f32 = 4.0;
/// The blur ends at this many standard deviations.
const REACH: f32 = 3.0;

impl Node for Halation {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.strength == 0.0 || self.radius == 0.0 || self.tint == [0.0; 3] || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let sigma = self.radius * desc.size.height as f32;
        let halvings = (sigma / WIDEST).log2().ceil().max(0.0) as u32;
        let glow = Blur::reduced(pass, source, halvings, sigma, REACH);
        let is_whole = pass.desc(glow).size == desc.size;
        pass.function(&SHADER, if is_whole { "halation_pixel" } else { "halation" })
            .read("source", source)
            .read("glow", glow)
            .write("result", desc);
    }
}
