//! Saturation: scales the distance of colors from gray.

use afterimage_graph::prelude::*;

use afterimage_color::adaptation::luminance_weights;

static SHADER: Shader = shader!("saturation");

node_kind! {
    /// Scales the distance of every color from the gray of its luminance.
    ///
    /// The luminance of linear light stays the same. Scene light may leave the triangle of Rec.709: its channels become
    /// negative. Light of a display stays in the display's gamut: its channels are clipped at 0.
    pub struct Saturation {
        /// 0 is gray, 1 changes nothing, 2 doubles the distance from gray.
        pub amount: f32 = 1.0 => within(0.0..=8.0), usually(0.0..=2.0), neutral(1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Linear light, before or after the tone curve.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The light.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for Saturation {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 1.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let ImageColor { state, colorimetry } = pass.color("source");
        let kernel = if state == ColorState::DisplayLinear { "saturation_display" } else { "saturation_scene" };
        pass.function(&SHADER, kernel)
            .set("luminance_weights", luminance_weights(&colorimetry.primaries).to_array())
            .write("result", desc);
    }
}
