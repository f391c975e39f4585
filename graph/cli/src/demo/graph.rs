//! Graphs of built-in pipelines.

use afterimage_graph::check::Graph;
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_pipelines::BuiltIn;

use crate::args::{KindOptions, PipelineOptions};
use crate::failure::Failure;
use crate::pipeline::PipelineFile;

/// The built-in scene, with what a renderer gives besides its light.
pub(super) const RENDERER: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene", "depth": "scene.projected", "normal": "scene.normal", "motion": "scene.motion" },
)"#;

/// The graph of a built-in pipeline.
pub(super) fn graph(registry: &Registry, name: &str, text: &str, sets: Vec<String>) -> Result<Graph, Failure> {
    let options = PipelineOptions { sets, facts: Vec::new(), tier: None, kinds: KindOptions::default() };
    let document = parse(&format!("{name}.ron"), text)?;
    Ok(PipelineFile::new(&document, registry, &BuiltIn).check(&options)?.0)
}
