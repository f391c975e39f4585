//! Ssao: ambient occlusion from depth by points in a hemisphere.

use afterimage_graph::prelude::*;

use crate::surface::NormalSpace;
use crate::visibility::{self, Occlusion, OcclusionSize};

static SHADER: Shader = shader!("ssao");

node_kind! {
    /// Darkens corners and gaps by points in the hemisphere over each pixel: the classic ambient occlusion.
    ///
    /// A point counts as occluded where the depth image shows something nearer, unless that is farther from the pixel
    /// than the radius. Mittring, "Finding Next Gen", 2007. The points are turned differently in each of four by four
    /// pixels, and a mean on the same surface makes them one. measurements/depth.md compares it with rays and with
    /// `Gtao`, whose horizons have a closed form.
    ///
    /// `result` is the light times the visibility, so place it before exposure, fog and bloom. A renderer that has its
    /// ambient light apart multiplies that one with 1 - `occlusion`. The projection may be any, perspective or
    /// orthographic. What lies outside of the image is not counted. Alpha passes unchanged.
    pub struct Ssao {
        /// Share of the occlusion. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// The radius of the hemisphere.
        pub radius: f32 = 0.6 => within(0.001..=1000.0), usually(0.1..=4.0), logarithmic(), unit("m");
        /// How far behind the surface a point must lie: more than the depth is rounded by.
        pub bias: f32 = 0.02 => within(0.0..=100.0), usually(0.0..=0.1), unit("m"), neutral(0.0);
        /// Exponent of the visibility: more than 1 is darker than it is.
        pub power: f32 = 1.0 => within(0.25..=4.0), usually(0.5..=2.0), neutral(1.0);
        /// Points for each pixel.
        pub samples: u32 = 16 => within(1.0..=64.0), usually(8.0..=64.0), quality(64u32, [32, 16, 8]), live();
        /// The size at which it is computed.
        pub size: OcclusionSize = OcclusionSize::Full => quality(OcclusionSize::Full, [OcclusionSize::Half]);
        /// Means over four by four pixels of a surface, one after the other. 0 shows the noise.
        pub denoise: u32 = 1 => within(0.0..=3.0);
        /// The space that `normal` is in.
        pub space: NormalSpace = NormalSpace::View => when_wired("normal", true);
    }

    const INPUTS: &'static [Input] = visibility::INPUTS;
    const OUTPUTS: &'static [Output] = visibility::OUTPUTS;
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for Ssao {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        self.is_identity(inputs) || output == "result" && inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let occlusion = Occlusion {
            shader: &SHADER,
            functions: ["ssao", "ssao_normals"],
            size: self.size,
            denoise: self.denoise,
            space: self.space,
        };
        occlusion.record(pass, &[]);
    }
}
