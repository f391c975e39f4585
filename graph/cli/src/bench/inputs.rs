//! Something to look at for every pipeline: the built-in scene at its required inputs.

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use wgpu::TextureView;

use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::check_text;
use crate::session::{Clock, Session};

const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "result": "scene", "depth": "scene.depth", "normal": "scene.normal", "albedo": "scene.albedo" },
)"#;
/// The outputs that go to inputs of their name; every other input gets the light.
const DATA: [&str; 3] = ["depth", "normal", "albedo"];

/// The images of a pipeline's inputs. They stay the same, as in a program that renders to one texture.
pub(super) struct Inputs {
    pub(super) size: Size,
    pub(super) images: Vec<(String, TextureView, ImageDesc)>,
}

impl Inputs {
    pub(super) fn new(gpu: &Gpu, registry: &Registry, graph: &Graph, size: Size) -> Result<Self, Failure> {
        let required: Vec<&str> = graph.inputs.iter().filter(|i| !i.optional).map(|i| i.name.as_str()).collect();
        if required.is_empty() {
            return Ok(Self { size, images: Vec::new() });
        }
        let options = PipelineOptions { sets: Vec::new(), facts: Vec::new(), tier: None, nodes: Vec::new() };
        let (scene, _) = check_text("scene.ron", SCENE, registry, &options)?;
        let mut session = Session::new(gpu, scene, Default::default(), Default::default());
        session.render(size, &[], Clock { reset: true, ..Clock::default() })?;
        let image = |name: &&str| {
            let output = if DATA.contains(name) { name } else { "result" };
            let view = session.output_texture(output).create_view(&Default::default());
            ((*name).to_owned(), view, ImageDesc::new(size))
        };
        Ok(Self { size, images: required.iter().map(image).collect() })
    }

    /// The image of the first input.
    pub(super) fn first(&self) -> Option<&TextureView> {
        self.images.first().map(|(_, view, _)| view)
    }
}
