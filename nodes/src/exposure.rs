//! Exposure: scales scene light by a power of two.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("exposure");

params! {
    /// Scales the light of the scene by 2^stops, so that what matters lies where the tone curve is best.
    ///
    /// With `meter` wired, the x of that value is added: the exposure that a metering node found, with `stops` as a correction on top.
    /// Results end at 65504, the largest half float. Bloom, local tone mapping and curves want exposed light.
    pub struct Exposure {
        /// Powers of two: 1 doubles the light, -1 halves it, 0 leaves it as it is.
        pub stops: f32 = 0.0 => within(-24.0..=24.0), usually(-6.0..=6.0), unit("stops"), neutral(0.0);
    }
}

impl Node for Exposure {
    const INPUTS: &'static [Input] = &[
        Input::image("source", "Light of the scene.").accepts(&[ColorState::Scene]),
        Input::new("meter", PortType::Value, "Stops to add, in x: the result of a metering node.").optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Exposed), "The light times 2^stops, at most 65504.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        (self.stops == 0.0 && arrivals.is_absent("meter")).then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = if pass.wired("meter") { "exposure_metered" } else { "exposure" };
        pass.function(&SHADER, kernel).set("gain", f64::from(self.stops).exp2()).write("result", desc);
    }
}
