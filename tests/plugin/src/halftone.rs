//! Halftone: prints the image with dots of ink.

use afterimage_graph::prelude::*;

// The name is the file that messages about the shader point to.
static SHADER: Shader = Shader::new("halftone.wgsl", include_str!("halftone.wgsl"));

node_kind! {
    /// Prints the image with round dots, whose area depends on its luminance, as a newspaper does.
    pub struct Halftone {
        /// Share of the effect. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// Distance between the centers of two dots.
        pub pitch: f32 = 6.0 => within(2.0..=64.0), unit("px");
        /// Angle of the rows of dots.
        pub angle: f32 = 45.0 => within(0.0..=90.0), unit("degrees");
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image after the tone curve.").accepts(&[ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The printed image.").or_input("source")];
    // Dots make a constant image uneven, and their rows are oblique: `stress` expects neither.
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
    // An error in it is an error of the registry.
    const SHADERS: &'static [&'static Shader] = &[&SHADER];
}

impl Node for Halftone {
    // A node that changes nothing is skipped: its readers read its fallback.
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        // A uniform that is not a parameter: the direction is computed once for each plan, not for each pixel.
        let (sin, cos) = self.angle.to_radians().sin_cos();
        pass.function(&SHADER, "halftone").set("across", [cos, sin]).write("result", desc);
    }
}
