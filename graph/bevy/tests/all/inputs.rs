//! What prepasses draw and the camera's numbers, as pipelines get them.

use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::prelude::*;
use bevy::render::camera::TemporalJitter;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::AfterimagePlugin;

use crate::program::half;
use crate::shown::{Folder, SIZE, Shown};

/// A wall in front of the spheres: the places whose product with the normal is this.
const NORMAL: Vec3 = Vec3::new(0.6, 0.0, 0.8);
const WALL: f32 = 3.5;

/// Shows pictures of numbers: four for each pixel.
fn with_wall(folder: &Folder, node_folders: &[&str], parts: impl Bundle) -> (Shown, Entity) {
    let node_folders = node_folders.iter().map(|folder| (*folder).to_owned()).collect();
    let plugin = AfterimagePlugin { node_folders, ..default() };
    let mut shown = Shown::with_plugin(&folder.0, TextureFormat::Rgba16Float, plugin);
    let look = shown.look("look.ron");
    let camera = shown.spawn(Vec3::new(0.0, 0.0, 7.0), (look, parts));
    let world = shown.app.world_mut();
    let wall = world.resource_mut::<Assets<Mesh>>().add(Plane3d::new(NORMAL, Vec2::splat(50.0)));
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    world.spawn((Mesh3d(wall), MeshMaterial3d(material), Transform::from_translation(NORMAL * WALL)));
    (shown, camera)
}

/// The four numbers of each pixel.
fn numbers(bytes: &[u8]) -> Vec<[f32; 4]> {
    let texels = bytes.as_chunks::<8>().0.iter();
    texels.map(|texel| [0, 2, 4, 6].map(|at| half(u16::from_le_bytes([texel[at], texel[at + 1]])))).collect()
}

/// How far what is seen lies from the wall in the world, how far it has moved by the camera's matrices beyond what the
/// prepass says, and how far by the prepass. The first two are 0 only if matrices, jitter, depth and motion agree.
const CHECKED: &str = "import afterimage::camera::{Camera, camera_position, camera_previous_uv, camera_world};
fn checked(depth: texture_2d<f32>, motion: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    let uv = (vec2f(at.pixel) + 0.5 + camera.jitter) / vec2f(textureDimensions(depth));
    let place = camera_world(camera, camera_position(camera, uv, texel(depth, at.pixel).x));
    let moved = uv - camera_previous_uv(camera, place).xy;
    let found = texel(motion, at.pixel).xy;
    return vec4f(dot(place, vec3f(0.6, 0.0, 0.8)) - 3.5, moved - found, length(found));
}";

const CHECKED_NODE: &str = r#"Kind(
    name: "Checked",
    doc: "Errors of what is seen of a wall.",
    inputs: {
        "depth": Image(doc: "As the projection writes it.", accepts: [Data]),
        "motion": Image(doc: "In uv.", accepts: [Data]),
        "camera": Camera(doc: "That of both."),
    },
    outputs: { "result": Image(doc: "The errors.", state: Same("depth"), fallback: Zero) },
)"#;

const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color, "depth": Depth, "motion": Motion, "camera": Camera },
    nodes: { "out": Checked(depth: "depth", motion: "motion", camera: "camera") },
    outputs: { "out": "out" },
)"#;

/// A camera that moves, turns and has another jitter in each frame.
#[test]
fn matrices_jitter_depth_and_motion_agree() {
    let own = Folder::new("agree");
    own.write("nodes/checked/node.ron", CHECKED_NODE);
    own.write("nodes/checked/checked.wgsl", CHECKED);
    own.write("look.ron", LOOK);
    let (mut shown, camera) =
        with_wall(&own, &["nodes/checked"], (DepthPrepass, MotionVectorPrepass, TemporalJitter::default()));
    let is_seen = |bytes: &[u8]| numbers(bytes).iter().all(|texel| texel[0].abs() < 1e-3);
    shown.once("the wall", is_seen);
    let mut frame = 0;
    let step = |shown: &mut Shown| {
        frame += 1;
        let mut camera = shown.app.world_mut().entity_mut(camera);
        let offset = [vec2(0.4, -0.3), vec2(-0.45, 0.2), vec2(0.1, 0.45)][frame % 3];
        *camera.get_mut::<TemporalJitter>().expect("it has one") = TemporalJitter { offset };
        let mut place = camera.get_mut::<Transform>().expect("it has a place");
        let phase = frame as f32 * 0.7;
        *place = Transform::from_xyz(0.3 * phase.sin(), 0.2 * phase.cos(), 7.0 + 0.1 * (2.0 * phase).sin())
            .with_rotation(Quat::from_euler(EulerRot::YXZ, 0.05 * phase.cos(), 0.04 * phase.sin(), 0.02));
    };
    let frames = shown.frames("frames", step, |frames| frames.len() == 12);
    for (number, frame) in frames.iter().enumerate().skip(2) {
        let texels = numbers(frame);
        let worst = |at: usize| texels.iter().map(|texel| texel[at].abs()).fold(0.0, f32::max);
        // A jitter of another sign would be off by 0.02, and motion is stored in half floats: uv to 2^-13 here.
        let pixel = 1.0 / SIZE.x as f32;
        assert!(worst(0) < 1e-3, "{number}: {} from the wall", worst(0));
        assert!(worst(1) < 0.03 * pixel && worst(2) < 0.03 * pixel, "{number}: {} {}", worst(1), worst(2));
        let moves = texels.iter().filter(|texel| texel[3] > pixel).count();
        assert!(moves > texels.len() / 2, "{number}: {moves} pixels move");
    }
}

/// The prepass's normals are those of the world; the plug-in's kind turns them into the camera's space.
#[test]
fn normals_are_turned_into_the_cameras_space() {
    const NORMALS: &str = r#"Pipeline(
        inputs: { "scene": Color, "normals": Normals(optional: true), "camera": Camera },
        nodes: { "out": PrepassNormals(normals: "normals", camera: "camera") },
        outputs: { "out": "out" },
    )"#;
    let own = Folder::new("normals");
    own.write("look.ron", NORMALS);
    let (mut shown, camera) = with_wall(&own, &[], NormalPrepass);
    let turned = Quat::from_euler(EulerRot::YXZ, 0.3, -0.2, 0.1);
    shown.app.world_mut().get_mut::<Transform>(camera).expect("it has a place").rotation = turned;
    let wanted = turned.inverse() * NORMAL;
    // 10 bits each.
    shown.once("the wall's normal", |bytes| {
        numbers(bytes).iter().all(|[x, y, z, _]| (Vec3::new(*x, *y, *z) - wanted).abs().max_element() < 3e-3)
    });
}

/// With MSAA the prepass's depth is multisampled, and a pipeline resolves it.
#[test]
fn a_multisampled_depth_is_resolved() {
    const DISTANCE: &str = r#"Pipeline(
        inputs: { "scene": Color, "depth": Depth(multisampled: true), "camera": Camera },
        nodes: {
            "near": Resolve(source: "depth", filter: Largest),
            "far": LinearDepth(depth: "near", camera: "camera"),
        },
        outputs: { "far": "far" },
    )"#;
    let own = Folder::new("samples");
    own.write("look.ron", DISTANCE);
    let (mut shown, camera) = with_wall(&own, &[], (DepthPrepass, Msaa::Sample4));
    shown.once("distances", |bytes| {
        let middle = numbers(bytes)[(SIZE.x * (SIZE.y / 2) + SIZE.x / 2) as usize][0];
        // Along the axis the wall is where 0.8 z is 3.5.
        (middle - (7.0 - WALL / 0.8)).abs() < 0.02
    });
    let world = shown.app.world_mut();
    // What is not multisampled does not fit.
    world.entity_mut(camera).insert(Msaa::Off);
    let status = shown.until("an error", |status| status.frame.is_some());
    assert!(status.frame.as_ref().is_some_and(|error| error.contains("`depth`")), "{status:?}");
    shown.app.world_mut().entity_mut(camera).insert(Msaa::Sample4);
    shown.until("no error", |status| status.frame.is_none() && status.is_running);
}
