//! Light, depth and motion.

use afterimage_graph::node::NodeKind;
use afterimage_nodes::DemoScene;

use super::super::shadow_rays::{DepthMap, lamp};
use super::kinds::{Clay, Gray, Lamplight, SLICES, marched};
use super::sheet::Crop;
use super::{Page, Panel, size};
use crate::support::docs;

/// The room of clay with few samples of occlusion, and the room at night with a lamp of 0.3 m.
const NODES: &str = r#"
    "clay": Clay(normal: "room.normal", camera: "camera"),
    "noisy": Gtao(source: "clay", depth: "room.depth", camera: "camera", normal: "room.normal", radius: 1.0, slices: 1,
                  denoise: 0),
    "lamp": Lamplight(depth: "room.depth", normal: "room.normal", albedo: "room.albedo", camera: "camera",
                      light: "light", color: (26.0, 19.0, 12.0)),
    "map": DepthMap(light: "light", side: 1024),
    "lit": Composite(base: "lamp", bloom: "room", blend: Add, strength: 0.04),
"#;

const SHADOW: &str = "light_diameter: 0.3";
const MIST: &str = "density: 0.4, falloff: 1.8, most: 0.9, color: (0.28, 0.3, 0.34)";
const LENS: &str = "focus: 3.6, f_stop: 1.4, focal_length: 85.0, rings: 12, largest: 0.04";

/// A depth buffer, eight times as bright, and distances, of which white is ten meters.
fn linear_depth(crop: Crop) -> Panel {
    let nodes = r#"
        "LinearDepth": LinearDepth(depth: "room.projected", camera: "camera"),
        "written": Gray(source: "room.projected", scale: 8.0), "LinearDepth-0": Encode(source: "written"),
        "meters": Gray(source: "LinearDepth", scale: 0.1), "LinearDepth-1": Encode(source: "meters"),
    "#;
    Panel { kind: "LinearDepth", nodes: nodes.to_owned(), crop }
}

fn panels() -> Vec<Panel> {
    let room = |wires| ("room", wires);
    let seen = "depth: \"room.depth\", camera: \"camera\",";
    let surfaces = "depth: \"room.depth\", camera: \"camera\", normal: \"room.normal\",";
    let surfaces_alone = "depth: \"room.depth\", normal: \"room.normal\",";
    let clay = ("noisy", surfaces_alone);
    let moving = "motion: \"room.motion\", depth: \"room.depth\",";
    let shadowed = format!(
        "\"ShadowMask\": ShadowMask(source: \"lamp\", {surfaces} map: \"map\", light: \"light\", {SHADOW}), \
         \"shadowed\": Composite(base: \"ShadowMask\", bloom: \"room\", blend: Add, strength: 0.04),"
    );
    let whole = Crop::new(0, 0, 1280);
    let outline = "depth_threshold: 0.02, color: (0.01, 0.012, 0.02)";
    vec![
        linear_depth(whole),
        Panel::light(("Outline", outline), room(surfaces_alone), 0.5, Crop::new(0, 200, 640)),
        Panel::light(("Gtao", "radius: 0.8, slices: 4, steps: 8"), room(surfaces), 1.0, Crop::new(780, 400, 320)),
        Panel::light(("Ssao", "radius: 0.8, samples: 32"), room(surfaces), 1.0, Crop::new(0, 440, 320)),
        Panel::light(("BilateralBlur", "radius: 6"), clay, 1.0, Crop::new(395, 430, 160)),
        Panel::of_light("ShadowMask", &shadowed, "lit", "shadowed", 1.0, Crop::new(0, 360, 640)),
        Panel::light(("Fog", MIST), room(seen), 0.5, whole),
        Panel::light(("VolumetricComposite", "far: 16.0"), room("depth: \"room.depth\", volume: \"fog\","), 0.5, whole),
        Panel::light(("DepthOfField", LENS), room("depth: \"room.depth\","), 0.5, Crop::new(0, 200, 640)),
        Panel::light(("MotionBlur", "samples: 64"), room(moving), 0.5, Crop::new(900, 530, 320)),
    ]
}

pub(super) fn page() -> Page {
    let size = size(1280);
    // A pixel of a small frame is wide.
    let step = if docs::are_written() { 0.004 } else { 0.06 };
    let camera = DemoScene { walk: 0.15, step, ..DemoScene::default() }.camera(size);
    let volume = if docs::are_written() { (160, 90) } else { (16, 9) };
    Page {
        inputs: "\"camera\": Camera, \"light\": Camera, \"fog\": Color(volume: true)",
        nodes: format!(
            "\"room\": DemoScene(walk: 0.15, step: {step:?}, time: 1.0, dt: 0.04, objects: 2, samples: 16), {NODES}"
        ),
        panels: panels(),
        own: vec![
            NodeKind::of::<Clay>(),
            NodeKind::of::<DepthMap>(),
            NodeKind::of::<Gray>(),
            NodeKind::of::<Lamplight>(),
        ],
        images: vec![("fog", marched(&camera, volume))],
        blocks: vec![("camera", camera), ("light", lamp())],
        slices: SLICES,
        ..Page::new("kinds-depth.jpg", size)
    }
}
