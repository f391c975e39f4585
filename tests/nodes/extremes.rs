//! Kinds that read a camera, with depths, motion and normals at the ends of what a renderer may give.

use afterimage_graph::node::{CAMERA, Camera, NodeKind, PortType};
use glam::camera::rh::proj::directx;
use glam::{Mat4, vec3};

use crate::support::gpu::{Picture, Run, SLICES, graph};

const SIDES: [u32; 2] = [24, 16];

/// The cameras: at the origin, in perspective and parallel, and a perspective one far away, which was elsewhere before.
fn cameras() -> [(&'static str, Camera); 3] {
    let perspective = directx::perspective_infinite_reverse(1.0, 1.5, 0.1).to_cols_array_2d();
    let parallel = directx::orthographic(-3.0, 3.0, -2.0, 2.0, 0.1, 50.0).to_cols_array_2d();
    let view = |x: f32| Mat4::from_translation(vec3(x, -3000.0, 1.0)).to_cols_array_2d();
    let still = Mat4::IDENTITY.to_cols_array_2d();
    [
        ("at the origin", Camera::still(still, perspective)),
        ("at the origin, parallel", Camera::still(still, parallel)),
        ("far away", Camera { previous_view: view(-9000.0), ..Camera::still(view(9000.0), perspective) }),
    ]
}

/// The number of a depth image at an index.
type Depth = fn(u32) -> f32;

/// The inputs for depth, motion and normals.
struct Given {
    name: &'static str,
    depth: Depth,
    motion: f32,
    normal: [f32; 3],
}

const FRONT: [f32; 3] = [0.0, 0.0, 1.0];

const GIVEN: [Given; 6] = [
    Given { name: "depth 0", depth: |_| 0.0, motion: 0.0, normal: FRONT },
    Given { name: "depth 1", depth: |_| 1.0, motion: 0.0, normal: FRONT },
    Given { name: "infinite depth", depth: |_| f32::INFINITY, motion: 0.0, normal: FRONT },
    Given {
        name: "depths of all kinds",
        depth: |i| [f32::NAN, 0.0, 1e-30, 1.0, 3.0, 65504.0, 1e30, f32::INFINITY][i as usize % 8],
        motion: 0.01,
        normal: [0.6, 0.0, 0.8],
    },
    // In widths and heights of the image, or in pixels: thousands of pixels in both.
    Given { name: "motion of thousands of pixels", depth: |_| 3.0, motion: 5000.0, normal: FRONT },
    Given { name: "normals of NaN", depth: |i| 2.0 + 0.1 * (i % 5) as f32, motion: 0.0, normal: [f32::NAN; 3] },
];

/// The declaration of an input for a port, and its picture.
fn input(port: &str, ty: PortType, given: &Given, map: Depth) -> (&'static str, Picture) {
    let [width, height] = SIDES;
    let index = |x: u32, y: u32| 3 * x + 5 * y;
    let picture = |pixel: &dyn Fn(u32, u32) -> [f32; 4]| Picture::new(width, height, pixel);
    match port {
        _ if ty == PortType::Volume => {
            ("Color(volume: true)", Picture::new(width, height * SLICES, |x, _| [0.1, 0.1, 0.1, x as f32 / 48.0]))
        }
        "depth" | "previous_depth" => ("Depth", picture(&|x, y| [(given.depth)(index(x, y)), 0.0, 0.0, 1.0])),
        "map" => ("Depth", picture(&|x, y| [map(index(x, y)), 0.0, 0.0, 1.0])),
        "normal" => ("Normals", picture(&|_, _| [given.normal[0], given.normal[1], given.normal[2], 0.0])),
        "motion" => ("Motion", picture(&|_, _| [given.motion, -given.motion, 0.0, 0.0])),
        "albedo" => ("Albedo", picture(&|_, _| [0.5, 0.4, 0.3, 1.0])),
        // The reflectance and the roughness of `Ssr`.
        "surface" => ("Data", picture(&|_, _| [0.5, 0.4, 0.3, 0.2])),
        // Light with an edge of a hundred to one.
        _ => {
            ("Color", picture(&|x, y| if index(x, y) % 7 < 3 { [0.1, 0.2, 0.3, 1.0] } else { [10.0, 5.0, 20.0, 1.0] }))
        }
    }
}

/// The output of a kind with all ports that hosts give; `map` is the depth map of a light.
fn rendered(kind: &NodeKind, camera: &Camera, given: &Given, map: Depth) -> Picture {
    let ports: Vec<_> = kind.inputs().iter().filter(|port| !matches!(port.ty, PortType::Value)).collect();
    let ports: Vec<_> = ports.into_iter().filter(|port| &*port.name != "previous_exposure").collect();
    let is_block = |port: &&&afterimage_graph::node::Input| port.ty == PortType::Block;
    let images: Vec<_> = ports.iter().filter(|port| !is_block(port)).collect();
    let pictures: Vec<_> = images.iter().map(|port| (&*port.name, input(&port.name, port.ty, given, map))).collect();
    let declared: String = pictures.iter().map(|(name, (ty, _))| format!("\"{name}\": {ty}, ")).collect();
    let blocks: String = ports.iter().filter(is_block).map(|port| format!("\"{}\": Camera, ", port.name)).collect();
    let wires: String = ports.iter().map(|port| format!("{0}: \"{0}\", ", port.name)).collect();
    let name = kind.name();
    let text = format!(
        "Pipeline(inputs: {{ {declared} {blocks} }}, nodes: {{ \"made\": {name}({wires}) }}, \
         outputs: {{ \"out\": \"made\" }})"
    );
    let graph = graph(&text);
    let mut run = Run::new(&graph).exact();
    for port in ports.iter().filter(is_block) {
        run = run.block(&port.name, camera);
    }
    let inputs: Vec<(&str, &Picture)> = pictures.iter().map(|(name, (_, picture))| (*name, picture)).collect();
    run.frame(&inputs).remove(0)
}

/// Panics unless the output of a kind is finite and not negative.
fn check(kind: &NodeKind, camera: &(&str, Camera), given: &Given) {
    let name = kind.name();
    let found = rendered(kind, &camera.1, given, given.depth);
    let is_good = |x: &f32| x.is_finite() && *x >= 0.0;
    let bad = found.pixels.as_flattened().iter().find(|x| !is_good(x));
    assert!(bad.is_none(), "{name}, a camera {}, {}: {bad:?}", camera.0, given.name);
    assert!(found.pixels.iter().any(|pixel| pixel[0] > 0.0), "{name}, a camera {}, {}: black", camera.0, given.name);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_with_a_camera_take_all_that_a_renderer_may_give() {
    let reads_a_camera = |kind: &&NodeKind| kind.inputs().iter().any(|port| port.block == Some(&CAMERA));
    let kinds: Vec<&NodeKind> = afterimage_nodes::ALL.iter().filter(reads_a_camera).collect();
    assert!(kinds.len() >= 6, "only {} kinds read a camera", kinds.len());
    for kind in kinds {
        let cameras = cameras();
        GIVEN.iter().for_each(|given| check(kind, &cameras[0], given));
        cameras[1..].iter().for_each(|camera| check(kind, camera, &GIVEN[3]));
    }
}

/// Depths that no surface has, each beside the one that they count as: at one place in four, and everywhere.
const IMPOSSIBLE: [[Depth; 2]; 5] = [
    [|i| if i % 4 == 0 { 0.0 } else { 3.0 }, |i| if i % 4 == 0 { 65504.0 } else { 3.0 }],
    [|i| if i % 4 == 0 { -3.0 } else { 3.0 }, |i| if i % 4 == 0 { 65504.0 } else { 3.0 }],
    [|_| 0.0, |_| 65504.0],
    [|_| -1e30, |_| 65504.0],
    [|_| f32::NAN, |_| 65504.0],
];

/// The judge is the same frame with a sky in these places.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn depth_that_cannot_be_is_far_in_every_kind() {
    let takes_depth = |kind: &&NodeKind| {
        // That of a projection may be 0.
        let is_distance = kind.name() != "LinearDepth";
        is_distance && kind.inputs().iter().any(|port| &*port.name == "depth" && port.ty == PortType::Image)
    };
    let kinds: Vec<&NodeKind> = afterimage_nodes::ALL.iter().filter(takes_depth).collect();
    assert!(kinds.len() >= 12, "only {} kinds read a depth", kinds.len());
    let [(_, camera), ..] = cameras();
    for kind in kinds {
        for (index, depths) in IMPOSSIBLE.into_iter().enumerate() {
            let [found, wanted] = depths.map(|depth| {
                let given = Given { name: "", depth, motion: 0.01, normal: [0.6, 0.0, 0.8] };
                rendered(kind, &camera, &given, |i| 0.1 * (i % 7) as f32)
            });
            assert!(found.pixels == wanted.pixels, "{}: depths {index} are not far", kind.name());
        }
    }
}
