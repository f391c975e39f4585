//! DemoScene: a test image that needs no file.

use afterimage_graph::node::{Camera, Matrix};
use afterimage_graph::prelude::*;
use glam::dcamera::rh::view::look_to_mat4;
use glam::{DMat4, DVec3, dvec3};

static LIBRARY: Library = Library::new(afterimage_shaders::DEMO);
static SHADER: Shader = shader!("demo_scene").with_library(&LIBRARY);

node_kind! {
    /// The built-in scene: a loft at golden hour, with a dim room, a bright window, a low sun, neon and fine detail.
    ///
    /// The shader traces rays through analytic shapes, so the scene needs no files and has any size. Equal parameters
    /// give equal images. With a lens of some diameter, `result` is what a thin lens shows; the other outputs are those
    /// of its middle. Light is in units of the room: its grays are 0.02 to 0.3, the sky is near 6, the neon near
    /// 11, the disc of the sun 18900. Alpha is the emissive strength: 0 for surfaces that emit no light.
    pub struct DemoScene {
        /// Time of the animation: the neon flickers, dust drifts.
        pub time: f32 = 0.0 => within(0.0..=1e6), unit("s");
        /// Stops from the room's gray to the disc of the sun. 0 makes all light equal.
        pub range: f32 = 18.0 => within(0.0..=24.0), unit("stops");
        /// Position of the camera: 0 is deep in the room, 1 in front of the window.
        pub walk: f32 = 0.0 => within(0.0..=1.0);
        /// How far `walk` has come since the previous frame: for `motion`.
        pub step: f32 = 0.0 => within(-1.0..=1.0), usually(0.0..=0.1), neutral(0.0);
        /// Time since the previous frame: for `motion` of the objects.
        pub dt: f32 = 0.0 => within(0.0..=10.0), usually(0.0..=0.1), unit("s"), neutral(0.0);
        /// Objects that move with the time: 1 is a balloon that drifts, 2 a ball that bounces, too.
        pub objects: u32 = 0 => within(0.0..=2.0), live();
        /// Samples of a pixel: 1 is aliased, 64 are a reference.
        pub samples: u32 = 4 => within(1.0..=64.0), live();
        /// The first sample of the sequence: the mean of nodes with 0, 64, 128 and 192 has 256 samples.
        pub first: u32 = 0 => within(0.0..=4096.0), live();
        /// How far all samples lie from their places in the pixel, v downwards: for temporal anti-aliasing.
        pub jitter: [f32; 2] = [0.0, 0.0] => within(-1.0..=1.0), usually(-0.5..=0.5), unit("pixels");
        /// The diameter of the lens: what is not in focus is blurred, which needs many samples. 0 is a pinhole.
        pub aperture: f32 = 0.0 => within(0.0..=1.0), usually(0.0..=0.2), unit("m"), neutral(0.0);
        /// The distance of the focus along the view axis.
        pub focus: f32 = 4.0
            => within(0.1..=1000.0), usually(0.5..=20.0), logarithmic(), unit("m"), unless("aperture", [0.0f32]);
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image(
            "result",
            OutputState::Always(ColorState::Scene),
            "The scene's light; alpha is the emissive strength.",
        ),
        Output::image(
            "depth",
            OutputState::Always(ColorState::Data),
            "Distance along the view axis in meters, 1000 for the sky, in x.",
        ),
        Output::image(
            "projected",
            OutputState::Always(ColorState::Data),
            "Depth as a renderer writes it, in x: 0.1 m over the distance, 0 for the sky.",
        ),
        Output::image("normal", OutputState::Always(ColorState::Data), "The view-space normal; (0, 0, 1) for the sky."),
        Output::image(
            "albedo",
            OutputState::Always(ColorState::Data),
            "Diffuse albedo; alpha is 1 where metering should count the pixel.",
        ),
        Output::image(
            "motion",
            OutputState::Always(ColorState::Data),
            "Where a surface is minus where it was in the previous frame, in uv, without the jitter.",
        ),
    ];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for DemoScene {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        let kernels = [
            ("result", "demo_scene"),
            ("depth", "demo_scene_depth"),
            ("projected", "demo_scene_projected"),
            ("normal", "demo_scene_normal"),
            ("albedo", "demo_scene_albedo"),
            ("motion", "demo_scene_motion"),
        ];
        for (port, function) in kernels {
            if pass.is_output_used(port) {
                let is_depth = matches!(port, "depth" | "projected");
                let desc = if is_depth { desc.format(Format::R32Float) } else { desc };
                pass.function(&SHADER, function).write(port, desc);
            }
        }
    }
}

/// Of half the vertical field of view, as the shader has it.
const TAN_FOV: f64 = 0.4245;
/// The near plane in meters.
const NEAR: f64 = 0.1;

impl DemoScene {
    /// The camera of an image of this size: for `projected`, with the near plane at 1 and an infinite far plane at 0,
    /// the motion since the previous frame, and the jitter.
    pub fn camera(&self, size: Size) -> Camera {
        let (walk, step) = (f64::from(self.walk), f64::from(self.step));
        let projection = projection(size.aspect());
        Camera { previous_view: view(walk - step), jitter: self.jitter, ..Camera::still(view(walk), projection) }
    }
}

fn projection(aspect: f64) -> Matrix {
    let height = 1.0 / TAN_FOV;
    let columns = DMat4::from_cols_array_2d(&[
        [height / aspect, 0.0, 0.0, 0.0],
        [0.0, height, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, NEAR, 0.0],
    ]);
    columns.as_mat4().to_cols_array_2d()
}

/// From the world to the camera, which stands on the path of `demo_scene_camera` in the shader.
fn view(walk: f64) -> Matrix {
    let w = walk.clamp(0.0, 1.0);
    let w = w * w * (3.0 - 2.0 * w);
    let eye = dvec3(1.75, 1.55, 4.7).lerp(dvec3(-0.45, 1.62, -2.3), w);
    let aim = dvec3(0.15, 1.72, -4.0).lerp(dvec3(-1.6, 2.0, -8.0), w);
    look_to_mat4(eye, (aim - eye).normalize(), DVec3::Y).as_mat4().to_cols_array_2d()
}
