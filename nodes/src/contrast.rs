//! Contrast: scales the distance of values from a pivot.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("contrast");

choices! {
    /// The numbers in which contrast is linear.
    pub enum ContrastForm {
        /// Stops: for light. Black stays black and no result is negative.
        Log,
        /// The values themselves: for encoded values, with a pivot of 0.5.
        Linear,
    }
}

node_kind! {
    /// Scales the distance of values from a pivot, which stays constant.
    ///
    /// `Log` is `pivot * (x / pivot)^amount`. `Linear` is `(x - pivot) * amount + pivot`, clipped at 0.
    pub struct Contrast {
        /// The numbers in which contrast is linear.
        pub form: ContrastForm = ContrastForm::Log;
        /// 1 changes nothing, more increases contrast, 0 maps everything to the pivot.
        pub amount: f32 = 1.0 => within(0.0..=8.0), usually(0.5..=2.0), neutral(1.0);
        /// The value that stays constant: 0.18 is middle gray in light, 0.5 the middle of encoded values.
        pub pivot: f32 = 0.18 => within(0.01..=16.0), usually(0.05..=0.6);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light, or an image after the tone curve.")
        .accepts(&[ColorState::Exposed, ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with its new contrast, 0 or more.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for Contrast {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 1.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = match self.form {
            ContrastForm::Log => "contrast_log",
            ContrastForm::Linear => "contrast_linear",
        };
        pass.function(&SHADER, kernel).write("result", desc);
    }
}
