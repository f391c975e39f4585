//! Brightness: adds a constant to every channel.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("brightness");

node_kind! {
    /// Adds a constant to every channel, as the brightness control of an image editor does.
    ///
    /// Intended for encoded values, where equal steps look alike in shadows and highlights. To scale light, use
    /// `Exposure`.
    pub struct Brightness {
        /// The constant. 0 changes nothing. Results below 0 become 0.
        pub amount: f32 = 0.0 => within(-1.0..=1.0), usually(-0.25..=0.25), neutral(0.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image after the tone curve.")
        .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image, 0 or more.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for Brightness {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&SHADER, "brightness").write("result", desc);
    }
}
