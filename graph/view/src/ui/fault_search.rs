//! The search for NaN and infinities in the images of all inputs and nodes, while they are stored.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_gpu::wgpu;
use afterimage_plan::Plan;

use super::pixel_inspector::textures;
use crate::model::{Model, PipelineInstance};
use crate::render::{Grid, Painter};
use crate::scopes::range;

/// Counts the pixels with NaN or infinities, of one image in each frame, in turns.
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
    /// The image that was sampled last has not arrived yet.
    is_reading: bool,
    /// The findings in each image that was sampled.
    found: BTreeMap<String, Found>,
}

/// The number of pixels of an image with NaN or infinities, and the least and the largest of its other numbers.
struct Found {
    faults: u64,
    range: (f32, f32),
}

impl FaultSearch {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self {
            grid: Grid::new(device),
            last: None,
            due: 0,
            plan: None,
            images: 0,
            is_reading: false,
            found: BTreeMap::new(),
        }
    }

    /// A new frame was rendered: all images are to be sampled again.
    pub(super) fn begin(&mut self) {
        self.due = usize::MAX;
    }

    /// Samples the next image, if all are stored. Of a volume, faults are counted in all slices.
    pub(super) fn record(&mut self, model: &Model, painter: &Painter, encoder: &mut wgpu::CommandEncoder) {
        let stored = model.inspector().stored().filter(|_| !model.inspector().is_compiling());
        let plan = stored.and_then(PipelineInstance::plan);
        if plan.map(Arc::as_ptr) != self.plan.as_ref().map(Arc::as_ptr) {
            (self.plan, self.found, self.last) = (plan.cloned(), BTreeMap::new(), None);
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
            (self.last, self.due, self.is_reading) = (Some(name.clone()), self.due.min(textures.len()) - 1, true);
        }
    }

    /// Requests what was sampled, and counts what has arrived; call it after the commands are submitted.
    pub(super) fn take(&mut self) {
        self.grid.request();
        let Some(pixels) = self.grid.take() else { return };
        self.is_reading = false;
        let Some(name) = &self.last else { return };
        let faults = pixels.iter().map(|pixel| pixel[3] as u64).sum();
        self.found.insert(name.clone(), Found { faults, range: range(&pixels) });
    }

    /// The images with NaN or infinities, and the number of such pixels in each.
    pub(super) fn found(&self) -> impl Iterator<Item = (&str, u64)> {
        self.found.iter().filter(|(_, found)| found.faults > 0).map(|(name, found)| (&**name, found.faults))
    }

    /// The least and the largest number of an image, once it was sampled.
    pub(super) fn range(&self, image: &str) -> Option<(f32, f32)> {
        self.found.get(image).map(|found| found.range)
    }

    /// States what was searched.
    pub(super) fn statement(&self) -> String {
        match self.found.len() {
            _ if self.plan.is_none() => "Nothing is wrong in the text and in the shown image. Probe also searches all \
                                         other images for NaN and infinities."
                .into(),
            some if some < self.images => {
                format!("Nothing is wrong so far: {some} of {} images have no NaN and no infinities.", self.images)
            }
            _ if self.due > 0 || self.is_reading => {
                "Nothing is wrong so far: the images of the newest frame are being searched.".into()
            }
            all => format!("Nothing is wrong: none of {all} images has NaN or infinities."),
        }
    }
}
