//! Fxaa: anti-aliasing of a finished image.

use afterimage_graph::prelude::*;

use crate::antialiasing;

static SHADER: Shader = shader!("fxaa");

choices! {
    /// Search distance along an edge to each side, and the number of reads: presets 39, 25 and 12 of FXAA 3.11.
    pub enum FxaaSearch {
        /// 26.5 pixels in 11 reads.
        Long,
        /// 22.5 pixels in 7 reads.
        Medium,
        /// 20.5 pixels in 4 reads: ends of edges are missed by some pixels.
        Short,
    }
}

node_kind! {
    /// Smooths the steps of edges in a finished image, from its colors alone: FXAA.
    ///
    /// Lottes, "FXAA", NVIDIA, 2009, in the form of FXAA 3.11 for quality. An edge is found by its contrast, followed
    /// to both of its ends, and each pixel next to it is read between the two sides of the edge. Place it last, before
    /// grain and dither: noise makes edges. Text and fine patterns lose sharpness; `subpixel` says how much. Alpha is
    /// filtered like color. Brightness is the luminance of encoded colors, and the square root of that of
    /// display-linear ones.
    pub struct Fxaa {
        /// How much dots and lines of one pixel are dimmed: 0 leaves them, 1 is the softest.
        pub subpixel: f32 = 0.75 => within(0.0..=1.0);
        /// The least contrast of an edge, as a share of the brightest of its pixels.
        pub threshold: f32 = 0.125 => within(0.03..=1.0), usually(0.06..=0.33);
        /// The least contrast of an edge in dark parts.
        pub floor: f32 = 0.0312 => within(0.0..=1.0), usually(0.01..=0.1);
        /// How far an edge is followed.
        pub search: FxaaSearch = FxaaSearch::Long
            => quality(FxaaSearch::Long, [FxaaSearch::Medium, FxaaSearch::Short]);
    }

    const INPUTS: &'static [Input] = antialiasing::INPUTS;
    const OUTPUTS: &'static [Output] = antialiasing::OUTPUTS;
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, ..Invariants::DEFAULT };
}

impl Fxaa {
    fn function(&self, is_linear: bool) -> &'static str {
        match (self.search, is_linear) {
            (FxaaSearch::Long, false) => "fxaa_long",
            (FxaaSearch::Medium, false) => "fxaa_medium",
            (FxaaSearch::Short, false) => "fxaa_short",
            (FxaaSearch::Long, true) => "fxaa_long_light",
            (FxaaSearch::Medium, true) => "fxaa_medium_light",
            (FxaaSearch::Short, true) => "fxaa_short_light",
        }
    }
}

impl Node for Fxaa {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let is_linear = antialiasing::is_linear(pass);
        pass.function(&SHADER, self.function(is_linear)).read("source", source).write("result", desc);
    }
}
