//! The search for NaN in the images of all inputs and nodes, while they are stored.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_gpu::wgpu;
use afterimage_plan::Plan;

use super::pixel_inspector::textures;
use crate::model::{Model, PipelineInstance};
use crate::render::{Grid, Painter};

/// Counts the pixels with NaN, of one image in each frame, in turns.
pub(super) struct FaultSearch {
    grid: Grid,
    /// The image that was sampled last.
    last: Option<String>,
    /// The number of images to sample until all have been since the last new frame.
    due: usize,
    /// The plan that stores the images.
    plan: Option<Arc<Plan>>,
    /// The number of images that the plan stores.
    images: usize,
    /// The number of pixels with NaN in each image that was sampled.
    counts: BTreeMap<String, u64>,
}

impl FaultSearch {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self { grid: Grid::new(device), last: None, due: 0, plan: None, images: 0, counts: BTreeMap::new() }
    }

    /// A new frame was rendered: all images are to be sampled again.
    pub(super) fn begin(&mut self) {
        self.due = usize::MAX;
    }

    /// Samples the next image, if all are stored. Of a volume, that is the middle slice.
    pub(super) fn record(&mut self, model: &Model, painter: &Painter, encoder: &mut wgpu::CommandEncoder) {
        let stored = model.inspector().stored().filter(|_| !model.inspector().is_compiling());
        let plan = stored.and_then(PipelineInstance::plan);
        if plan.map(Arc::as_ptr) != self.plan.as_ref().map(Arc::as_ptr) {
            (self.plan, self.counts, self.last) = (plan.cloned(), BTreeMap::new(), None);
        }
        let Some(stored) = stored.filter(|_| self.due > 0) else { return };
        let textures = textures(model.frame_images(), stored);
        self.images = textures.len();
        let after = |name: &str| textures.iter().position(|(known, _)| known == name).map_or(0, |place| place + 1);
        let next = self.last.as_deref().map_or(0, after);
        let Some((name, texture)) = textures.get(next).or(textures.first()) else { return };
        let is_volume = texture.dimension() == wgpu::TextureDimension::D3;
        let slice = if is_volume { texture.depth_or_array_layers() / 2 } else { 0 };
        if self.grid.record(&model.gpu().device, painter, encoder, texture, slice) {
            (self.last, self.due) = (Some(name.clone()), self.due.min(textures.len()) - 1);
        }
    }

    /// Requests what was sampled, and counts what has arrived; call it after the commands are submitted.
    pub(super) fn take(&mut self) {
        self.grid.request();
        let (Some(pixels), Some(name)) = (self.grid.take(), &self.last) else { return };
        self.counts.insert(name.clone(), pixels.iter().map(|pixel| pixel[3] as u64).sum());
    }

    /// The images with NaN, and the number of such pixels in each.
    pub(super) fn found(&self) -> impl Iterator<Item = (&str, u64)> {
        self.counts.iter().filter(|(_, count)| **count > 0).map(|(name, count)| (&**name, *count))
    }

    /// States what was searched.
    pub(super) fn statement(&self) -> String {
        match self.counts.len() {
            _ if self.plan.is_none() => {
                "Nothing is wrong in the text and in the shown image. Probe also searches all other images for NaN."
                    .into()
            }
            some if some < self.images => {
                format!("Nothing is wrong so far: {some} of {} images have no NaN.", self.images)
            }
            all => format!("Nothing is wrong: none of {all} images has NaN."),
        }
    }
}
