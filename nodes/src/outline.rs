//! Outline: lines along the edges of surfaces.

use afterimage_graph::prelude::*;

use crate::surface;

static SHADER: Shader = shader!("outline");

node_kind! {
    /// Draws lines along the edges of surfaces, from depth and normals.
    ///
    /// An edge is where the inverse of the depth bends: it is linear on a plane in perspective, so planes have no lines
    /// at any slope. With normals, folds between surfaces of equal depth are edges, too. Lines cover what is
    /// transparent.
    pub struct Outline {
        /// Share of the line's color. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// The color of lines, in the units of the source.
        pub color: [f32; 3] = [0.0, 0.0, 0.0] => within(0.0..=1000.0), usually(0.0..=1.0);
        /// Half of the width of a line.
        pub width: u32 = 1 => within(1.0..=16.0), unit("pixels"), live();
        /// The bend of the inverse depth at which a line begins, as a share of it. At twice that it is full.
        pub depth_threshold: f32 = 0.05 => within(0.0..=4.0), usually(0.01..=0.5), logarithmic();
        /// 1 minus the cosine between two normals at which a line begins. At twice that it is full.
        pub normal_threshold: f32 = 0.3 => within(0.0..=2.0), usually(0.05..=1.0), when_wired("normal", true);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image.").accepts(STATES),
        Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]),
        Input::image("normal", "Normals of any length, in x, y and z.").accepts(&[ColorState::Data]).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with lines.").or_input("source")];
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear, ColorState::Encoded];

impl Node for Outline {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let size = surface::size_of(pass, "source");
        let depth = surface::at_size(pass, "depth", size);
        if pass.wired("normal") {
            let normal = surface::at_size(pass, "normal", size);
            let call = pass.function(&SHADER, "outline_normals").read("depth", depth);
            call.read("normal", normal).write("result", ImageDesc::new(size));
        } else {
            pass.function(&SHADER, "outline").read("depth", depth).write("result", ImageDesc::new(size));
        }
    }
}
