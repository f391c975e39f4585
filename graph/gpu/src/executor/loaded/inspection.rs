//! Images, buffers and pass times of the last frame.

use std::sync::Arc;

use afterimage_graph::node::BufferId;
use afterimage_plan::Plan;
use wgpu::{Buffer, Texture};

use crate::executor::host_draw::DrawTargets;
use crate::executor::loaded::LoadedPlan;
use crate::executor::loaded::residency::{ImageBinding, Residency, ring_place};
#[cfg(not(target_family = "wasm"))]
use crate::{error::GpuError, timing::Timestamps};

impl LoadedPlan {
    /// The buffer of a table or value by its label, `node.port`. `None` if the plan has none, for example because the
    /// node is skipped.
    pub fn buffer(&self, label: &str) -> Option<&Buffer> {
        let index = self.plan.buffers.iter().position(|buffer| buffer.label == label)?;
        self.residency.buffers.get(index)
    }

    #[doc(hidden)] // For the crate `afterimage`.
    pub fn plan_buffer(&self, buffer: BufferId) -> &Buffer {
        &self.residency.buffers[buffer.0 as usize]
    }

    /// The texture of an image by its label or its name in the plan, as far as it is not the host's. See
    /// `afterimage::Post::image`.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn image(&self, name: &str) -> Option<&Texture> {
        let Plan { images, .. } = &*self.plan;
        let by_label = images.iter().position(|image| image.label == name);
        let index = by_label.or_else(|| self.plan.image_names().iter().position(|known| known == name))?;
        Some(match &self.residency.bindings[index] {
            ImageBinding::Output(_, stored) | ImageBinding::Fixed(stored) => &stored.texture,
            ImageBinding::Ring(ring, behind) => &ring[ring_place(ring.len(), self.last_index, *behind)].texture,
            ImageBinding::Input(_) | ImageBinding::Unused => return None,
        })
    }

    /// The attachments of a pass that the host fills, by the name of its node; `None` if the plan has none.
    pub fn draw_targets(&self, node: &str) -> Option<DrawTargets> {
        DrawTargets::of(&self.plan, node)
    }

    /// The number of passes that the last recorded frame ran, if it was a [redraw](crate::FrameKind::Redraw) of those
    /// that depend on changed values.
    pub fn passes_redrawn(&self) -> Option<usize> {
        self.due.redrawn()
    }

    /// True if the last recorded frame has run passes that run [after a change](afterimage_plan::Refresh::OnChange) of
    /// their uniforms: the first frame of a plan does.
    pub fn has_run_on_change(&self) -> bool {
        self.due.any_on_change(&self.plan)
    }

    /// The memory of the plan.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn residency(&self) -> &Arc<Residency> {
        &self.residency
    }

    /// Milliseconds of each pass of the last submitted frame; `None` if they are not measured. Waits for it.
    ///
    /// # Errors
    /// The device is lost.
    #[cfg(not(target_family = "wasm"))]
    pub fn pass_times(&self) -> Result<Option<Vec<f64>>, GpuError> {
        self.timing.as_ref().map(Timestamps::read).transpose()
    }

    /// The timestamps of the frame that is recorded, and the nanoseconds of a tick; `None` if passes are not timed.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn timestamps(&self) -> Option<(&Buffer, f32)> {
        Some(self.timing.as_ref()?.resolved())
    }
}
