//! The node kind `MyKind`.

use afterimage_graph::prelude::*;

// The name is the file that messages about the shader point to.
static SHADER: Shader = Shader::new("my_kind.wgsl", include_str!("my_kind.wgsl"));

node_kind! {
    /// Tints the image.
    pub struct MyKind {
        /// Share of the effect. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// The color of what was white.
        pub tint: [f32; 3] = [1.0, 0.8, 0.6] => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image, before or after the tone curve.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The tinted image.").or_input("source")];
}

impl Node for MyKind {
    // A node that changes nothing is skipped: its readers read its fallback.
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&SHADER, "my_kind").write("result", desc);
    }
}

/// The kinds of this crate, for a registry.
pub const ALL: &[NodeKind] = &[NodeKind::of::<MyKind>()];
