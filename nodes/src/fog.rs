//! Fog: distance and height fog with light of the sun in it.

use afterimage_graph::node::CAMERA;
use afterimage_graph::prelude::*;

use crate::surface;

static SHADER: Shader = shader!("fog");

node_kind! {
    /// Puts fog between the camera and the scene: uniform, or thinner with the height, lit by the sky and by the sun.
    ///
    /// Along each ray the light of the scene is multiplied by exp(-optical depth), and the rest is `color` plus
    /// `sun_color` times the phase function of Henyey and Greenstein (times 4 pi). The optical depth of a density that
    /// falls exponentially with the height has a closed form (Quilez, "Better Fog", 2010). Place it before exposure.
    /// The depth is the distance along the view axis in meters; the sky has a large one. With a camera, directions and
    /// heights are those of the world, so the fog stays where it is when the camera moves; `eye_height` and `fov` are
    /// not used. Without one, directions are in view space: x to the right, y up, z toward the viewer. Alpha passes
    /// unchanged.
    pub struct Fog {
        /// Share of the light that a meter of fog absorbs, at `level`. 0 changes nothing.
        pub density: f32 = 0.02 => within(0.0..=10.0), usually(0.0..=0.2), unit("1/m"), neutral(0.0);
        /// How fast the density falls with the height: by 1/e in 1/falloff meters. 0 is the same fog everywhere.
        pub falloff: f32 = 0.0 => within(0.0..=10.0), usually(0.0..=0.5), unit("1/m"), neutral(0.0);
        /// The height at which the fog has its density.
        pub level: f32 = 0.0 => within(-10000.0..=10000.0), usually(-100.0..=100.0), unit("m");
        /// The height of the camera, if none is wired.
        pub eye_height: f32 = 1.7
            => within(-10000.0..=10000.0), usually(0.0..=100.0), unit("m"), when_wired("camera", false);
        /// Upwards, of length 1.
        pub up: [f32; 3] = [0.0, 1.0, 0.0] => within(-1.0..=1.0);
        /// The distance at which the fog begins.
        pub start: f32 = 0.0 => within(0.0..=10000.0), usually(0.0..=100.0), unit("m"), neutral(0.0);
        /// The largest share of the light that is absorbed: below 1, the sky stays visible.
        pub most: f32 = 1.0 => within(0.0..=1.0);
        /// The light that the fog scatters from all sides, in the units of the source.
        pub color: [f32; 3] = [0.5, 0.6, 0.7] => within(0.0..=1000.0), usually(0.0..=4.0);
        /// Toward the sun, of length 1.
        pub sun: [f32; 3] = [0.0, 0.0, -1.0] => within(-1.0..=1.0);
        /// The light of the sun that the fog scatters, of all directions on average.
        pub sun_color: [f32; 3] = [0.0, 0.0, 0.0] => within(0.0..=1000.0), usually(0.0..=4.0);
        /// How much of the sun's light is scattered forwards: 0 to all sides, near 1 a glow around the sun.
        pub anisotropy: f32 = 0.7 => within(-0.9..=0.9), usually(0.0..=0.9);
        /// Vertical field of view of the camera, if none is wired.
        pub fov: f32 = 46.0 => within(1.0..=170.0), usually(20.0..=110.0), unit("degrees"), when_wired("camera", false);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The light of the scene.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("depth", "Distance along the view axis in meters, in x.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera, for fog that stands in the world.").optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The scene in fog.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for Fog {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.density == 0.0 || self.most == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let size = surface::size_of(pass, "source");
        let depth = surface::at_size(pass, "depth", size);
        let tan_fov = (0.5 * f64::from(self.fov)).to_radians().tan();
        let name = if pass.wired("camera") { "fog_camera" } else { "fog" };
        pass.function(&SHADER, name).read("depth", depth).set("tan_fov", tan_fov).write("result", ImageDesc::new(size));
    }
}
