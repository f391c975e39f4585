//! DemoScene: a test image that needs no file.

use afterimage_graph::prelude::*;

static LIBRARY: Library = Library::new(afterimage_shaders::DEMO);
static SHADER: Shader = shader!("demo_scene").with_library(&LIBRARY);

params! {
    /// The built-in scene: a loft at golden hour, with a dim room, a bright window, a low sun, neon and fine detail.
    ///
    /// The shader traces rays through analytic shapes, so the scene needs no files and has any size. Equal parameters
    /// give equal images. Light is in units of the room: its greys are 0.02 to 0.3, the sky is near 6, the neon near
    /// 11, the disc of the sun 18900. Alpha is the emissive strength: 0 for surfaces that emit no light.
    pub struct DemoScene {
        /// Time of the animation: the neon flickers, dust drifts.
        pub time: f32 = 0.0 => within(0.0..=1e6), unit("s");
        /// Stops from the room's grey to the disc of the sun. 0 makes all light equal.
        pub range: f32 = 18.0 => within(0.0..=24.0), unit("stops");
        /// Position of the camera: 0 is deep in the room, 1 in front of the window.
        pub walk: f32 = 0.0 => within(0.0..=1.0);
        /// How far `walk` has come since the previous frame: for `motion`.
        pub step: f32 = 0.0 => within(-1.0..=1.0), usually(0.0..=0.1), neutral(0.0);
    }
}

impl Node for DemoScene {
    const INPUTS: &'static [Input] = &[];
    const OUTPUTS: &'static [Output] = &[
        Output::image(
            "result",
            OutputState::Always(ColorState::Scene),
            "The scene's light; alpha is the emissive strength.",
        ),
        Output::image(
            "depth",
            OutputState::Always(ColorState::Data),
            "Distance along the view axis in metres, 1000 for the sky, in x.",
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
            "Where a surface is minus where it was in the previous frame, in uv; only the camera moves.",
        ),
    ];

    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size());
        let kernels = [
            ("result", "demo_scene"),
            ("depth", "demo_scene_depth"),
            ("normal", "demo_scene_normal"),
            ("albedo", "demo_scene_albedo"),
            ("motion", "demo_scene_motion"),
        ];
        for (port, function) in kernels {
            if pass.wanted(port) {
                pass.function(&SHADER, function).write(port, desc);
            }
        }
    }
}
