//! Edges and detail, in squares for pixels.

use afterimage_graph::image::Size;

use super::super::taa;
use super::sheet::Crop;
use super::{Page, Panel, size};
use crate::support::docs;
use crate::support::gpu::{Picture, Run, graph};

const WALK: &str = "walk: 0.56";

/// The standard places of four samples in a pixel, less its center: those of Direct3D, Metal and Vulkan.
const PLACES: [[f32; 2]; 4] = [[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]];

/// Four samples of each pixel, as the input of a multisampled texture has them: four pictures one below the other.
fn samples(size: Size) -> Picture {
    let node =
        |(i, [x, y]): (usize, &[f32; 2])| format!("\"s{i}\": DemoScene({WALK}, samples: 1, jitter: ({x:?}, {y:?})), ");
    let nodes: String = PLACES.iter().enumerate().map(node).collect();
    let outputs: String = (0..4).map(|i| format!("\"s{i}\": \"s{i}\", ")).collect();
    let graph = graph(&format!("Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})"));
    let mut run = Run::new(&graph);
    run.size = size;
    let pixels = run.frame(&[]).into_iter().flat_map(|sample| sample.pixels).collect();
    Picture { width: size.width, height: 4 * size.height, pixels }
}

const RESOLVE: &str = "gain: 0.5";
const TAA: &str = "white: 8.0";

/// The last frame of a walk with one sample in each pixel, and the same smoothed over time.
fn walk(size: Size) -> [Picture; 2] {
    let frames = if docs::are_written() { 16 } else { 2 };
    let shot = taa::shot(frames, (0.53, 0.002), 1.0 / 24.0, size);
    let node = format!(
        "\"result\": Taa(source: \"in\", history: \"result@previous\", depth: \"depth\", camera: \"camera\", \
         motion: \"motion\", previous_depth: \"before\", {TAA})"
    );
    let smooth = taa::smoothed(&node, &shot);
    [shot.last().expect("there are frames").light.clone(), smooth]
}

pub(super) fn page() -> Page {
    let size = size(640);
    // What a resolve by the device gives, and weights for the stops of the panel.
    let resolved = format!(
        "\"plain\": Resolve(source: \"samples\", gain: 0.0), \"weighted\": Resolve(source: \"samples\", {RESOLVE}),"
    );
    let (bars, leaves) = (Crop::new(290, 60, 80), Crop::new(460, 150, 80));
    let panels = vec![
        Panel::of_light("Resolve", &resolved, "plain", "weighted", -1.0, Crop::new(205, 92, 40)),
        Panel::of_light("Taa", "", "one", "smooth", -1.0, leaves),
        Panel::encoded(("Smaa", ""), "aliased", -1.0, bars),
        Panel::encoded(("Fxaa", ""), "aliased", -1.0, bars),
        Panel::encoded(("Cas", "sharpness: 0.5"), "smooth", 0.5, Crop::new(64, 150, 80)),
        Panel::light(("Sharpen", "amount: 1.0"), ("room", ""), 0.5, Crop::new(560, 150, 80)),
    ];
    let [one, smooth] = walk(size);
    Page {
        inputs: "\"samples\": Color(multisampled: true), \"one\": Color, \"smooth\": Color",
        nodes: format!("\"room\": DemoScene({WALK}, samples: 16), \"aliased\": DemoScene({WALK}, samples: 1),"),
        panels,
        images: vec![("samples", samples(size)), ("one", one), ("smooth", smooth)],
        ..Page::new("kinds-edges.jpg", size)
    }
}
