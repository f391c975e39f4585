//! Contrast: spreads values about a pivot.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("contrast");

choices! {
    /// In which numbers contrast is a line.
    pub enum ContrastForm {
        /// In stops: what light wants. Black stays black and nothing falls below it.
        Log,
        /// In the values themselves: what encoded values want, with a pivot of 0.5.
        Linear,
    }
}

params! {
    /// Spreads values about a pivot that stays where it is.
    ///
    /// `Log` is `pivot * (x / pivot)^amount`, `Linear` is `(x - pivot) * amount + pivot`, cut off at 0.
    pub struct Contrast {
        /// In which numbers contrast is a line.
        pub form: ContrastForm = ContrastForm::Log;
        /// 1 changes nothing, more is more contrast, 0 makes everything the pivot.
        pub amount: f32 = 1.0 => within(0.0..=8.0), usually(0.5..=2.0), neutral(1.0);
        /// The value that stays: 0.18 is middle grey in light, 0.5 the middle of encoded values.
        pub pivot: f32 = 0.18 => within(0.01..=16.0), usually(0.05..=0.6);
    }
}

impl Node for Contrast {
    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light, or a picture after the tone curve.")
        .accepts(&[ColorState::Exposed, ColorState::DisplayLinear, ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The spread values, 0 or more.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn identity(&self, _: &Arrivals) -> Option<Fallback> {
        (self.amount == 1.0).then_some(Self::FALLBACK)
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
