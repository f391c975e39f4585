//! Inspection of intermediate images, tables and values.
//!
//! A second pipeline with the same graph stores every image of every node in memory of its own. The shown picture is
//! planned as for a host, and does not change.

use afterimage::host::Watch;
use afterimage_gpu::wgpu;
use afterimage_graph::image::{ImageDesc, Size};

use super::{FrameImages, PipelineInstance, PlanPreset};

/// An intermediate result that is shown instead of the output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InspectedWire {
    /// An input of the pipeline, or `node.port`.
    pub wire: String,
    /// Index of one of the wire's images: a level of a pyramid, a step of the node, or its history.
    pub index: usize,
    /// The slice of a volume.
    pub slice: u32,
}

impl InspectedWire {
    /// The first image of a wire.
    pub fn new(wire: impl Into<String>) -> Self {
        Self { wire: wire.into(), index: 0, slice: 0 }
    }
}

/// An image that can be inspected.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectedImage {
    /// Its name in the plan.
    pub name: String,
    pub desc: ImageDesc,
}

/// The wire that is shown, and the pipelines whose images are read.
#[derive(Default)]
pub struct Inspector {
    pub(super) wire: Option<InspectedWire>,
    /// The table or value of the wire, as the shown pipeline computes it.
    pub(super) watch: Option<Watch>,
    /// The values of a pixel are read at every node.
    pub(super) reads_pixels: bool,
    /// The images of all wires are shown.
    pub(super) shows_wires: bool,
    stored: Option<PipelineInstance>,
    reference: Option<PipelineInstance>,
}

impl Inspector {
    /// The intermediate result that is shown.
    pub fn wire(&self) -> Option<&InspectedWire> {
        self.wire.as_ref()
    }

    /// The pipeline that stores all images, while they are read.
    pub fn stored(&self) -> Option<&PipelineInstance> {
        self.stored.as_ref()
    }

    /// The pipeline that stores all images in 32 bits, while they are read.
    pub fn reference(&self) -> Option<&PipelineInstance> {
        self.reference.as_ref()
    }

    /// The presets of both pipelines, and true for one that is read.
    pub(super) fn needs(&self) -> [(PlanPreset, bool); 2] {
        let stores = self.wire.is_some() || self.reads_pixels || self.shows_wires;
        [(PlanPreset::Inspect, stores), (PlanPreset::Reference, self.reads_pixels)]
    }

    pub(super) fn instance(&mut self, preset: PlanPreset) -> &mut Option<PipelineInstance> {
        if preset == PlanPreset::Reference { &mut self.reference } else { &mut self.stored }
    }

    pub(super) fn instances(&mut self) -> impl Iterator<Item = &mut PipelineInstance> {
        self.stored.iter_mut().chain(&mut self.reference)
    }

    /// True while the plan that stores the images is being made.
    pub fn is_compiling(&self) -> bool {
        self.stored.as_ref().is_some_and(|instance| instance.plan().is_none() || instance.is_changing())
    }

    /// The stored images of a wire: levels of a pyramid and histories, then the other images of its node.
    pub fn images(&self, wire: &str) -> Vec<InspectedImage> {
        let Some(plan) = self.stored.as_ref().and_then(PipelineInstance::plan) else { return Vec::new() };
        let node = wire.rsplit_once('.').map_or(wire, |(node, _)| node);
        let named = plan.image_names().into_iter().zip(&plan.images);
        let used = named.filter(|(_, image)| image.lifetime.is_some());
        let of_node = used.filter(|(name, _)| belongs(name, node));
        let mut images: Vec<InspectedImage> =
            of_node.map(|(name, image)| InspectedImage { name, desc: image.desc }).collect();
        images.sort_by_key(|image| !belongs(&image.name, wire));
        images
    }

    /// The image of a wire, once a frame has rendered it.
    pub(super) fn image_of(
        &self,
        inspected: &InspectedWire,
        frame_images: &FrameImages,
    ) -> Option<(InspectedImage, wgpu::Texture)> {
        let InspectedWire { wire, index, .. } = inspected;
        if let Some((_, view)) = frame_images.images.iter().find(|(name, _)| name == wire) {
            let texture = view.texture().clone();
            let desc = ImageDesc::new(Size::new(texture.width(), texture.height()));
            return Some((InspectedImage { name: wire.clone(), desc }, texture));
        }
        let images = self.images(wire);
        let image = images.get((*index).min(images.len().checked_sub(1)?))?.clone();
        let texture = self.stored.as_ref()?.image(&image.name)?.clone();
        Some((image, texture))
    }
}

/// True if an image is that of a wire or a node, one of its levels or steps, or its history.
pub(crate) fn belongs(image: &str, owner: &str) -> bool {
    image.strip_prefix(owner).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '@', '#']))
}
