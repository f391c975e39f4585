//! Images of panels that no kind makes: a lamp alone, a sky over clay, sunlight in fog, and numbers as gray.

use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, Camera};
use afterimage_graph::prelude::*;

use crate::support::gpu::{Picture, Run, graph_with};

node_kind! {
    /// Light of a lamp at the camera's place that surfaces send back, without shadows.
    pub struct Lamplight {
        /// The light at one meter from a white surface.
        pub color: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=1000.0);
    }

    const INPUTS: &'static [Input] = &[
        DEPTH,
        NORMAL,
        Input::image("albedo", "The share of light that is reflected.").accepts(&[ColorState::Data]),
        SEEN_FROM,
        Input::block("light", &CAMERA, "The camera at the light."),
    ];
    const OUTPUTS: &'static [Output] = OUTPUTS;
}

node_kind! {
    /// The room of clay under an even sky, without occlusion.
    pub struct Clay {
        /// The light of surfaces that face upwards. Those that face downwards have a third of it.
        pub light: f32 = 0.5 => within(0.0..=1000.0);
    }

    const INPUTS: &'static [Input] = &[NORMAL, SEEN_FROM];
    const OUTPUTS: &'static [Output] = OUTPUTS;
}

node_kind! {
    /// Numbers of data as gray for a display.
    pub struct Gray {
        /// Factor of the numbers in x. White is 1.
        pub scale: f32 = 1.0 => within(0.0..=1000.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Numbers.").accepts(&[ColorState::Data])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::DisplayLinear), "The gray.")];
}

node_kind! {
    /// Fog in the room: the light that a meter of it scatters toward the camera in rgb, and the light that it takes in
    /// alpha, for each texel of a volume that lies before the camera. The slices lie one below the other.
    pub struct Froxels {
        /// The light that a meter takes.
        pub density: f32 = 0.02 => within(0.0..=10.0);
        /// The sunlight that a meter scatters.
        pub dust: f32 = 0.0015 => within(0.0..=10.0);
    }

    const INPUTS: &'static [Input] = &[SEEN_FROM];
    const OUTPUTS: &'static [Output] = OUTPUTS;
}

static ROOM: Library = Library::new(afterimage_shaders::DEMO);
static SHADER: Shader = Shader::new(
    "gallery.wgsl",
    "import afterimage::camera::{Camera, camera_place, camera_world};
import package::loft::{LOFT_OUTSIDE, LOFT_ROOM_HIGH, LOFT_ROOM_LOW, loft_trace};
import package::loft_lamps::{LOFT_SUN, LOFT_SUNLIGHT};
import package::loft_pose::loft_pose;
import package::ray::{Ray, ray_direction};
struct Lamplight { color: vec3f }
fn lamplight(
    depth: vec4f,
    normal: vec4f,
    albedo: vec4f,
    camera: Camera,
    light: Camera,
    at: Point,
    params: Lamplight,
) -> vec4f {
    let place = camera_world(camera, camera_place(camera, at.uv, depth.x));
    let n = normalize((camera.inverse_view * vec4f(normal.xyz, 0.0)).xyz);
    let way = light.inverse_view[3].xyz - place;
    let cosine = max(dot(n, way) / length(way), 0.0);
    return vec4f(albedo.rgb * params.color * (cosine / dot(way, way)), 0.0);
}
struct Clay { light: f32 }
fn clay(normal: vec4f, camera: Camera, params: Clay) -> vec4f {
    let up = (camera.inverse_view * vec4f(normal.xyz, 0.0)).y;
    return vec4f(vec3f(1.0, 0.97, 0.92) * params.light * (2.0 + up) / 3.0, 0.0);
}
struct Gray { scale: f32 }
fn gray(source: vec4f, params: Gray) -> vec4f {
    return vec4f(vec3f(clamp(source.x * params.scale, 0.0, 1.0)), 1.0);
}
struct Froxels { density: f32, dust: f32, slices: f32, near: f32, far: f32 }
const SAMPLES: i32 = 16;
fn froxels(camera: Camera, at: Point, params: Froxels) -> vec4f {
    let rows = at.size.y / params.slices;
    let slice = floor((f32(at.pixel.y) + 0.5) / rows);
    let first = vec3f(f32(at.pixel.x), f32(at.pixel.y) - slice * rows, slice);
    var sum = vec4f();
    for (var i = 0; i < SAMPLES; i++) {
        // In the R3 sequence of Roberts, within the froxel.
        let inside = fract(0.5 + f32(i) * vec3f(0.8191725, 0.6710436, 0.5497005));
        let froxel = (first + inside) / vec3f(at.size.x, rows, params.slices);
        let distance = params.near * pow(params.far / params.near, froxel.z);
        let there = camera_place(camera, froxel.xy, distance);
        let place = camera_world(camera, there);
        // The fog is in the room.
        if any(place < LOFT_ROOM_LOW) || any(place > LOFT_ROOM_HIGH) { continue; }
        let away = normalize(place - camera.inverse_view[3].xyz);
        // Henyey and Greenstein, times 4 pi.
        let g = 0.6;
        let forward = (1.0 - g * g) / pow(1.0 + g * g - 2.0 * g * dot(away, LOFT_SUN), 1.5);
        let hit = loft_trace(Ray(place, ray_direction(LOFT_SUN)), loft_pose(0.0, 0));
        let sun = select(0.0, 1.0, hit.what == LOFT_OUTSIDE);
        let light = LOFT_SUNLIGHT * (params.dust * sun * forward / 12.566371)
            + vec3f(0.1, 0.12, 0.15) * params.density;
        // Of a meter along the view axis.
        sum += vec4f(light, params.density + params.dust) * (length(there) / distance);
    }
    return sum / f32(SAMPLES);
}
",
)
.with_library(&ROOM);

/// Slices, and their distances: as `VolumetricComposite` has them.
pub(super) const SLICES: u32 = 64;
const NEAR: f64 = 0.5;
const FAR: f64 = 16.0;

const DEPTH: Input = Input::image("depth", "Distances.").accepts(&[ColorState::Data]);
const NORMAL: Input = Input::image("normal", "Normals.").accepts(&[ColorState::Data]);
const SEEN_FROM: Input = Input::block("camera", &CAMERA, "The camera.");
const OUTPUTS: &[Output] = &[Output::image("result", OutputState::Always(ColorState::Scene), "The light.")];

impl Node for Lamplight {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        pass.function(&SHADER, "lamplight").write("result", desc);
    }
}

impl Node for Clay {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        pass.function(&SHADER, "clay").write("result", desc);
    }
}

impl Node for Gray {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        pass.function(&SHADER, "gray").write("result", desc);
    }
}

impl Node for Froxels {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        let call = pass.function(&SHADER, "froxels").set("slices", f64::from(SLICES));
        call.set("near", NEAR).set("far", FAR).write("result", desc);
    }
}

/// A volume as a march from the camera leaves it, of this size: scattered light, and the share that passes, both up to
/// the end of each slice.
pub(super) fn marched(camera: &Camera, (width, height): (u32, u32)) -> Picture {
    let text = "Pipeline(inputs: { \"camera\": Camera }, nodes: { \"fog\": Froxels(camera: \"camera\") }, \
                outputs: { \"fog\": \"fog\" })";
    let graph = graph_with(text, &[NodeKind::of::<Froxels>()]);
    let mut run = Run::new(&graph).camera(Some(camera)).exact();
    run.size = Size::new(width, height * SLICES);
    let mut volume = run.frame(&[]).remove(0);
    let end = |slice: u32| NEAR * (FAR / NEAR).powf(f64::from(slice) / f64::from(SLICES));
    for column in 0..width * height {
        let (mut light, mut passed) = ([0.0; 3], 1.0);
        for slice in 0..SLICES {
            let texel = &mut volume.pixels[(slice * width * height + column) as usize];
            let [r, g, b, taken] = texel.map(f64::from);
            let share = (-taken * (end(slice + 1) - end(slice))).exp();
            // A slice is of one fog: what it scatters is dimmed by itself, too.
            let seen = passed * (1.0 - share) / taken.max(1e-9);
            light = [light[0] + seen * r, light[1] + seen * g, light[2] + seen * b];
            passed *= share;
            *texel = [light[0], light[1], light[2], passed].map(|x| x as f32);
        }
    }
    volume
}
