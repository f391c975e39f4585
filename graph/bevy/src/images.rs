//! Images of a camera for a frame of a pipeline, and its viewport.

use afterimage::host::{Graph, Rectangle};
use afterimage::wgpu;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::render::view::{ExtractedView, ViewTarget};

/// The camera's image, depth, normals and motion.
const MAX_INPUTS: usize = 4;

/// The images of a camera by the names of the pipeline's inputs, in arrays: a frame allocates nothing.
pub(crate) struct Images<'a> {
    inputs: [(&'a str, &'a wgpu::TextureView); MAX_INPUTS],
    rectangles: [(&'a str, Rectangle); MAX_INPUTS + 1],
    count: usize,
    /// True if the camera has a part of its images only.
    has_rectangles: bool,
}

impl<'a> Images<'a> {
    /// Those of the prepasses by their names, and the camera's image for the first other input; then the output.
    pub(crate) fn new(
        graph: &'a Graph,
        target: &'a ViewTarget,
        prepass: Option<&'a ViewPrepassTextures>,
        part: Option<Rectangle>,
    ) -> Self {
        let scene: &wgpu::TextureView = target.main_texture_view();
        let rectangle = part.unwrap_or(Rectangle { x: 0, y: 0, width: 0, height: 0 });
        let output = graph.outputs.first().map_or("", |output| output.name.as_str());
        let mut images = Self {
            inputs: [("", scene); MAX_INPUTS],
            rectangles: [(output, rectangle); MAX_INPUTS + 1],
            count: 0,
            has_rectangles: part.is_some(),
        };
        let mut unused = Some(scene);
        for input in graph.inputs.iter().filter(|input| input.block.is_none() && !input.volume) {
            let view = match (input.name.as_str(), prepass) {
                // The texture has no stencil, and Bevy makes its view of the depth alone anew in each frame: bind groups
                // would be, too.
                ("depth", prepass) => prepass.and_then(|prepass| Some(&*prepass.depth.as_ref()?.texture.default_view)),
                ("normals", prepass) => prepass.and_then(|prepass| prepass.normal_view()).map(|view| &**view),
                ("motion", prepass) => prepass.and_then(|prepass| prepass.motion_vectors_view()).map(|view| &**view),
                _ if input.multisampled => None,
                _ => unused.take(),
            };
            // With MSAA, what prepasses draw is multisampled, too.
            let fits = |view: &&wgpu::TextureView| (view.texture().sample_count() > 1) == input.multisampled;
            if let Some(view) = view.filter(fits).filter(|_| images.count < MAX_INPUTS) {
                images.inputs[images.count] = (&input.name, view);
                images.rectangles[images.count + 1].0 = &input.name;
                images.count += 1;
            }
        }
        images
    }

    pub(crate) fn inputs(&self) -> &[(&'a str, &'a wgpu::TextureView)] {
        &self.inputs[..self.count]
    }

    pub(crate) fn rectangles(&self) -> &[(&'a str, Rectangle)] {
        &self.rectangles[..if self.has_rectangles { self.count + 1 } else { 0 }]
    }
}

/// The rectangle of a camera that has a part of its textures only.
pub(crate) fn part_of(view: &ExtractedView, target: &ViewTarget) -> Option<Rectangle> {
    let [x, y, width, height] = view.viewport.to_array();
    let part = Rectangle { x, y, width, height };
    let texture = target.main_texture();
    let whole = Rectangle { x: 0, y: 0, width: texture.width(), height: texture.height() };
    (part != whole).then_some(part)
}
