//! Images, buffers and pass times of the last frame, and labels for tools.

use wgpu::Buffer;

use super::Executor;
use crate::error::GpuError;
use crate::executor::loaded::residency::{ImageBinding, ring_place};
use crate::timing::Timing;

impl Executor {
    /// The buffer of a table or value by its label, `node.port`. `None` if the plan has none, for example because the
    /// node is skipped.
    pub fn buffer(&self, label: &str) -> Option<&Buffer> {
        let loaded = self.loaded.as_ref()?;
        let index = loaded.plan.buffers.iter().position(|buffer| buffer.label == label)?;
        loaded.residency.buffers.get(index)
    }

    /// The texture of an image by its label or its name in the plan, as far as it is not the host's. See
    /// `afterimage::Post::image`.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        let loaded = self.loaded.as_ref()?;
        let by_label = loaded.plan.images.iter().position(|image| image.label == name);
        let index = by_label.or_else(|| loaded.plan.image_names().iter().position(|known| known == name))?;
        let last_frame = self.frames.index.wrapping_sub(1);
        Some(match &loaded.residency.bindings[index] {
            ImageBinding::Output(_, stored) | ImageBinding::Fixed(stored) => &stored.texture,
            ImageBinding::Ring(ring, behind) => &ring[ring_place(ring.len(), last_frame, *behind)].texture,
            ImageBinding::Input(_) | ImageBinding::Unused => return None,
        })
    }

    /// The texture of an output that the host gave no image for.
    pub fn output(&self, name: &str) -> Option<&wgpu::Texture> {
        let loaded = self.loaded.as_ref()?;
        let output = loaded.plan.output(Some(name))?;
        match &loaded.residency.bindings[output.image.0 as usize] {
            ImageBinding::Output(_, stored) => Some(&stored.texture),
            _ => None,
        }
    }

    /// Labels each pass with its nodes in the commands, for tools such as RenderDoc.
    pub fn label_passes(&mut self, on: bool) {
        self.labeled = on;
        if let Some(loaded) = &mut self.loaded {
            loaded.labels = on.then(|| loaded.plan.pass_names());
        }
    }

    /// Measures the GPU time of each of the plan's passes from now on, in this plan and those after it. `false` before
    /// a plan is loaded, and where the device has no timestamps inside passes.
    ///
    /// # Errors
    /// The device is lost or has no memory for them.
    pub fn enable_timing(&mut self) -> Result<bool, GpuError> {
        let Some(loaded) = &mut self.loaded else { return Ok(false) };
        loaded.timing = Timing::watched(&self.compiler.device, &self.queue, loaded.passes.len() as u32)?;
        Ok(loaded.timing.is_some())
    }

    /// Milliseconds of each pass of the last submitted frame; `None` if they are not measured. Waits for it.
    ///
    /// # Errors
    /// The device is lost.
    #[cfg(not(target_family = "wasm"))]
    pub fn pass_times(&self) -> Result<Option<Vec<f64>>, GpuError> {
        let timing = self.loaded.as_ref().and_then(|loaded| loaded.timing.as_ref());
        timing.map(|timing| timing.read(&self.compiler.device)).transpose()
    }

    /// The timestamps of the frame that is recorded, and the nanoseconds of a tick; `None` if passes are not timed.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn timestamps(&self) -> Option<(&Buffer, f32)> {
        Some(self.loaded.as_ref()?.timing.as_ref()?.timestamps())
    }
}
