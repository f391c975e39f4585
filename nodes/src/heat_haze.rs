//! HeatHaze: hot air wavers before the picture.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("heat_haze");

node_kind! {
    /// Wavers as hot air does, where a mask states that the air is hot.
    ///
    /// The light of a pixel comes from a place next to it, by two octaves of noise that rise through the image with the
    /// time of the frame. The x of `mask` is the share of `strength` at a place of the result, from 0 to 1; it may have
    /// any size, and is filtered. Without a mask the whole image wavers. It is a warp: with a `LensDistortion` or a
    /// `ChromaticAberration` before or after it, it is one pass. Beyond the border the border is read. Every 4096 cells
    /// of noise it begins anew, after 17 minutes with the defaults.
    pub struct HeatHaze {
        /// The farthest way of a place where the mask is 1. 0 changes nothing.
        pub strength: f32 = 0.004 => within(0.0..=0.1), usually(0.0..=0.02), unit("heights"), neutral(0.0);
        /// The width of the larger swirls; the smaller ones have half of it.
        pub scale: f32 = 0.04 => within(0.001..=1.0), usually(0.01..=0.2), unit("heights");
        /// How fast they rise.
        pub speed: f32 = 0.25 => within(0.0..=4.0), usually(0.05..=1.0), unit("heights/s");
        /// The height of a swirl, as a multiple of its width.
        pub shape: f32 = 1.6 => within(0.25..=4.0), usually(1.0..=2.5);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image.").accepts(&[
            ColorState::Scene,
            ColorState::Exposed,
            ColorState::DisplayLinear,
            ColorState::Encoded,
            ColorState::Data,
        ]),
        Input::image("mask", "Where the air is hot, in x: 0 to 1.").accepts(&[ColorState::Data]).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image behind hot air.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { symmetric: false, keeps_constant: true, ..Invariants::DEFAULT };
}

impl Node for HeatHaze {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.strength == 0.0 || inputs.is_zero("mask") || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let function = if pass.wired("mask") { "heat_haze_masked" } else { "heat_haze" };
        pass.warp(&SHADER, function, source).label("heat_haze").write("result", desc);
    }
}
