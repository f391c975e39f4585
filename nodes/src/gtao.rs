//! Gtao: ambient occlusion from depth.

use afterimage_graph::prelude::*;

use crate::surface::{self, NormalSpace};
use crate::visibility::{self, Occlusion, OcclusionSize};

static SHADER: Shader = shader!("gtao");

node_kind! {
    /// Darkens corners and gaps, which less of the light around them reaches: ambient occlusion from depth.
    ///
    /// For each pixel, slices of the hemisphere over the surface, even around the direction to the camera, are searched
    /// for the highest horizon to both sides; the cosine-weighted light that they hide has a closed form. A bare plane
    /// hides nothing, wherever and at whatever angle it is seen. Slices differ within 4x4 pixels, and a mean on
    /// the same surface makes them one. Jimenez, Wu, Pesce and Jarabo, "Practical Realtime Strategies for Accurate
    /// Indirect Occlusion", 2016; measurements/depth.md compares it with rays. What lies outside of the image, or
    /// behind what is seen, occludes nothing.
    ///
    /// `result` is the light times the visibility, so place it before exposure, fog and bloom. A renderer that has its
    /// ambient light apart multiplies that one with 1 - `occlusion`. With `albedo`, light that bounces between bright
    /// surfaces fills a part of what is missing. The projection may be any, perspective or orthographic. Alpha passes
    /// unchanged.
    pub struct Gtao {
        /// Share of the occlusion. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// The distance from which nothing occludes.
        pub radius: f32 = 0.6 => within(0.001..=1000.0), usually(0.1..=4.0), logarithmic(), unit("m");
        /// The last part of the radius, over which occluders fade out.
        pub falloff: f32 = 0.6 => within(0.01..=1.0);
        /// Exponent of the visibility: more than 1 is darker than it is.
        pub power: f32 = 1.0 => within(0.25..=4.0), usually(0.5..=2.0), neutral(1.0);
        /// The longest way that is searched.
        pub largest: f32 = 0.2 => within(0.01..=1.0), usually(0.05..=0.5), unit("heights");
        /// Slices for each pixel; the denoiser makes sixteen times as many of them.
        pub slices: u32 = 2 => within(1.0..=16.0), quality(4u32, [2]), live();
        /// Samples of each slice to each side.
        pub steps: u32 = 4 => within(1.0..=32.0), quality(8u32, [6, 4]), live();
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

impl Node for Gtao {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        self.is_identity(inputs) || output == "result" && inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let longest = f64::from(self.largest) * f64::from(surface::size_of(pass, "source").height);
        let occlusion = Occlusion {
            shader: &SHADER,
            functions: ["gtao_visibility", "gtao_visibility_normals"],
            size: self.size,
            denoise: self.denoise,
            space: self.space,
        };
        occlusion.record(pass, &[("max_radius", longest)]);
    }
}
