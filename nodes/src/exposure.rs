//! Exposure: scales scene light by a power of two.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("exposure");

node_kind! {
    /// Scales scene light by 2^stops, so that the tone curve maps the important part of it well.
    ///
    /// With `meter` wired, the x of that value is added to `stops`: it is the exposure that a metering node computed.
    /// Results are limited to 65504, the largest half float. Bloom, local tone mapping and tone curves expect exposed
    /// light.
    pub struct Exposure {
        /// Exponent of the factor: 1 doubles the light, -1 halves it, 0 changes nothing.
        pub stops: f32 = 0.0 => within(-24.0..=24.0), usually(-6.0..=6.0), unit("stops"), neutral(0.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "Scene light.").accepts(&[ColorState::Scene]),
        Input::new("meter", PortType::Value, "Stops to add, in x: the result of a metering node.")
            .content("exposure")
            .only_x()
            .optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Exposed), "The light times 2^stops, at most 65504.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for Exposure {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.stops == 0.0 && inputs.is_absent("meter")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = if pass.wired("meter") { "exposure_metered" } else { "exposure" };
        pass.function(&SHADER, kernel).set("gain", f64::from(self.stops).exp2()).write("result", desc);
    }
}
