//! Smaa: anti-aliasing of a finished image by the shapes of its edges.

use afterimage_graph::prelude::*;

use crate::antialiasing;

static SHADER: Shader = shader!("smaa");

choices! {
    /// Search distance along edges to each side.
    pub enum SmaaSearch {
        /// 64 pixels along rows and columns, 16 along diagonals.
        Far,
        /// 32 pixels along rows and columns, 8 along diagonals.
        Middle,
        /// 16 pixels along rows and columns, and no diagonals.
        Near,
    }
}

node_kind! {
    /// Smooths the steps of edges in a finished image by their shapes: SMAA 1x.
    ///
    /// Jimenez and others, "SMAA: Enhanced Subpixel Morphological Antialiasing", 2012. Edges are found by contrast,
    /// followed to their ends, and drawn anew as straight lines; each pixel is mixed with its neighbor by the area
    /// that the line cuts off. Lines and text stay sharper than with `Fxaa`, and what is smaller than a pixel stays as
    /// it is: `Taa` is for that. Areas are computed, where the published method reads them from a table. Place it
    /// before grain and dither, and before `Encode` if you can: light is then mixed as light. Alpha is mixed like
    /// color. Three passes.
    pub struct Smaa {
        /// The least difference of a component of two pixels that is an edge: of encoded numbers, or of the square
        /// roots of light.
        pub threshold: f32 = 0.1 => within(0.01..=0.5), usually(0.05..=0.15);
        /// How round real corners become: 0 keeps them, 1 treats them as steps of an edge.
        pub corners: f32 = 0.25 => within(0.0..=1.0);
        /// How far edges are followed.
        pub search: SmaaSearch = SmaaSearch::Middle
            => quality(SmaaSearch::Far, [SmaaSearch::Middle, SmaaSearch::Near]);
    }

    const INPUTS: &'static [Input] = antialiasing::INPUTS;
    const OUTPUTS: &'static [Output] = antialiasing::OUTPUTS;
    // As published, what an edge is compared with, and a diagonal that takes its place, are those of the pixel at whose
    // left or upper border it lies: a mirrored image differs.
    const INVARIANTS: Invariants = Invariants { symmetric: false, ..Invariants::DEFAULT };
}

impl SmaaSearch {
    /// Pixels along rows and columns, and along diagonals.
    fn reach(self) -> (i32, i32) {
        match self {
            Self::Far => (64, 16),
            Self::Middle => (32, 8),
            Self::Near => (16, 0),
        }
    }
}

impl Node for Smaa {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let is_linear = antialiasing::is_linear(pass);
        // Flags and shares between 0 and 1.
        let [edges, weights] = ["edges", "weights"].map(|name| pass.transient(name, desc.format(Format::Rgba8Unorm)));
        let find = if is_linear { "smaa_edges_light" } else { "smaa_edges" };
        let (reach, diagonal_reach) = self.search.reach();
        for (function, argument, image, result) in
            [(find, "source", source, edges), ("smaa_weights", "edges", edges, weights)]
        {
            let pass = pass.function(&SHADER, function).set("reach", reach).set("diagonal_reach", diagonal_reach);
            pass.read(argument, image).write_to(result);
        }
        pass.function(&SHADER, "smaa").read("source", source).read("weights", weights).write("result", desc);
    }
}
