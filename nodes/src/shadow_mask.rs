//! ShadowMask: shadows of a light from its depth map.

use afterimage_graph::node::{CAMERA, FunctionPass};
use afterimage_graph::prelude::*;

use crate::surface::{self, NormalSpace};

static SHADER: Shader = shader!("shadow_mask");

choices! {
    /// Sampling pattern of the depth map around a place.
    pub enum ShadowTaps {
        /// A square, which gives the same shadow in each pixel of a surface.
        Square,
        /// A disc, turned differently in each pixel of four by four: rounder, with noise that a `BilateralBlur` of
        /// radius 4 takes away. A light of some size has it always.
        Disc,
    }
}

node_kind! {
    /// Darkens what a light does not reach: percentage-closer filtering of the light's depth map.
    ///
    /// `light` is the camera that the depth map was drawn with, perspective or orthographic, and `map` is what its
    /// projection wrote; the near plane may be at either end. Distances in meters are compared, so all biases are
    /// lengths or texels. What lies outside of the map or behind the light is lit, and what faces away from the light
    /// is not. Reeves, Salesin and Cook, "Rendering Antialiased Shadows with Depth Maps", 1987;
    /// graph/docs/measurements/depth.md compares it with rays.
    ///
    /// `result` is the source times the share of light that arrives, so the source is best the light of this lamp
    /// alone, and before `Taa`: a pixel of a smooth edge shows two surfaces, and the shadow is that of one. A renderer
    /// that adds lamps up multiplies each one with 1 - `shadow`. Alpha passes unchanged.
    ///
    /// Penumbrae are as wide as `kernel`, unless the light has a size: `angular_diameter` where its rays are parallel,
    /// `light_diameter` where its camera has a perspective. Then what blocks the light is searched, and penumbrae
    /// grow with its distance from the place: Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH sketches, 2005.
    pub struct ShadowMask {
        /// Share of the shadow. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// Taps of the square across and down, or the diameter of the disc: the least width of a penumbra. Each
        /// tap is filtered linearly over two by two texels.
        pub kernel: u32 = 3 => within(1.0..=7.0), unit("texels"), quality(3u32, [1]), live();
        /// Where the map is read.
        pub pattern: ShadowTaps = ShadowTaps::Square;
        /// Taps on the disc.
        pub taps: u32 = 16 => within(1.0..=64.0), usually(4.0..=32.0), quality(16u32, [8, 4]), live();
        /// How far before the surface an occluder must be: more than the depth map is rounded by.
        pub bias: f32 = 0.01 => within(0.0..=100.0), usually(0.0..=0.1), unit("m"), neutral(0.0);
        /// Bias by the slope of the surface: 1 is as much as a plane rises toward the light within the kernel, so that
        /// no plane shadows itself.
        pub slope_bias: f32 = 1.0 => within(0.0..=8.0), usually(0.0..=2.0), neutral(0.0);
        /// How far along its normal a place is moved, more the more the light grazes the surface.
        pub normal_bias: f32 = 0.0 => within(0.0..=8.0), usually(0.0..=3.0), unit("texels"), neutral(0.0);
        /// The space that `normal` is in.
        pub space: NormalSpace = NormalSpace::View => when_wired("normal", true);
        /// The diameter of a light whose camera has a perspective: a disc across its axis. 0 searches no blockers.
        pub light_diameter: f32 = 0.0 => within(0.0..=100.0), usually(0.0..=1.0), unit("m"), neutral(0.0);
        /// The angle that a light with parallel rays, whose camera is orthographic, has in the sky: the sun 0.53. 0
        /// searches no blockers.
        pub angular_diameter: f32 = 0.0 => within(0.0..=90.0), usually(0.0..=5.0), unit("degrees"), neutral(0.0);
        /// The widest penumbra, and the part of the map in which blockers are searched around a place.
        pub largest: f32 = 0.05 => within(0.0..=1.0), usually(0.01..=0.2), unit("map widths");
        /// Taps of the search.
        pub blocker_taps: u32 = 32 => within(1.0..=64.0), usually(8.0..=32.0), quality(32u32, [16, 8]), live();
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The light of the scene, best of this lamp alone.")
            .accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera."),
        Input::image("map", "The depth map: what the light's projection wrote, in x.").accepts(&[ColorState::Data]),
        Input::block("light", &CAMERA, "The camera at the light that the map was drawn with."),
        Input::image("normal", "Normals of any length, in x, y and z; without them, they are made from the depth.")
            .accepts(&[ColorState::Data])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::same("source"), "The light that arrives.").or_input("source"),
        Output::image(
            "shadow",
            OutputState::Always(ColorState::Data),
            "The share of the light that is blocked, in x; 0 in the others.",
        ),
    ];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl ShadowMask {
    fn set<'r, 'a>(&self, pass: FunctionPass<'r, 'a>) -> FunctionPass<'r, 'a> {
        let half = 0.5 * f64::from(self.angular_diameter);
        pass.set("is_disc", f64::from(u8::from(self.pattern == ShadowTaps::Disc)))
            .set("tangent", half.to_radians().tan())
    }

    /// The places in the world of all pixels.
    fn places(pass: &mut Recorder<'_>, size: Size) -> ImageId {
        let depth = surface::at_size(pass, "depth", size);
        // Half floats hold no places.
        let places = pass.transient_signed("places", ImageDesc::new(size).format(Format::Rgba32Float));
        pass.function(&SHADER, "shadow_mask_place").read("depth", depth).write_to(places);
        places
    }

    /// The normals in the world, if they are given.
    fn normals(&self, pass: &mut Recorder<'_>, size: Size) -> Option<ImageId> {
        let given = pass.wired("normal").then(|| surface::at_size(pass, "normal", size))?;
        if self.space == NormalSpace::World {
            return Some(given);
        }
        let turned = pass.transient_signed("turned", ImageDesc::new(size));
        pass.function(&SHADER, "shadow_mask_turned").read("normal", given).write_to(turned);
        Some(turned)
    }

    /// The share of the light that is blocked in each pixel.
    fn share(&self, pass: &mut Recorder<'_>, size: Size) -> ImageId {
        let (places, normals) = (Self::places(pass, size), self.normals(pass, size));
        let share = pass.transient("share", ImageDesc::new(size).format(Format::R16Float));
        let name = if normals.is_some() { "shadow_mask_normals" } else { "shadow_mask" };
        let call = self.set(pass.function(&SHADER, name)).read("places", places);
        match normals {
            Some(normals) => call.read("turned", normals).write_to(share),
            None => call.write_to(share),
        }
        share
    }
}

impl Node for ShadowMask {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        self.is_identity(inputs) || output == "result" && inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let size = surface::size_of(pass, "source");
        let share = self.share(pass, size);
        for (port, function) in [("result", "shadow_mask_lit"), ("shadow", "shadow_mask_shadow")] {
            if pass.is_output_used(port) {
                let call = self.set(pass.function(&SHADER, function));
                call.read("share", share).write(port, ImageDesc::new(size));
            }
        }
    }
}
