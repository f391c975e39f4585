//! The longest pipeline as a whole: over time, at extremes, and compared with its CPU reference.

mod extremes;
mod look;
mod order;
mod reference;
mod sequence;

use afterimage_graph::check::{Graph, GraphOutput, Source};
use afterimage_graph::image::Size;

use crate::support::gpu::{Picture, Run, built_in, graph};

const PIPELINE: &str = "tsushima.ron";

/// The built-in scene from deep in the room (0) to the window (1).
fn scene(width: u32, height: u32, walk: f64) -> Picture {
    let text = camera(walk);
    let graph = graph(&text);
    let mut run = Run::new(&graph);
    run.size = Size::new(width, height);
    run.frame(&[]).remove(0)
}

fn camera(walk: f64) -> String {
    format!(
        r#"Pipeline(inputs: {{}}, nodes: {{ "scene": DemoScene(walk: {walk:?}) }}, outputs: {{ "scene": "scene" }})"#
    )
}

/// The pipeline up to a node, whose result is the only output.
fn up_to(node: &str) -> Graph {
    let mut graph = built_in(PIPELINE, None);
    let (index, found) = graph.node(node).unwrap_or_else(|| panic!("{PIPELINE} has a node `{node}`"));
    let state = found.states[0].expect("its result is an image");
    let source = Source::Node { node: index, output: 0, previous: 0 };
    graph.outputs = vec![GraphOutput { name: node.into(), source, state, has_coverage: false }];
    graph
}

fn bits(pictures: &[Picture]) -> Vec<u32> {
    pictures.iter().flat_map(|picture| picture.pixels.as_flattened()).map(|x| x.to_bits()).collect()
}
