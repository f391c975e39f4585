//! A second executor that continues the plan in use while the first one runs the next plan, for a fade.

use std::sync::Arc;

use afterimage_plan::{Plan, PlanOutput};
use wgpu::{CommandEncoder, TextureFormat, TextureUsages, TextureView};

use super::Executor;
use super::frame::Frame;
use super::host_draw::host_node;
use super::recorded::Lost;
use crate::device::texture_format;
use crate::error::GpuError;
use crate::executor::bind::host_images::check_encoding;
use crate::executor::loaded::Loaded;
use crate::executor::loaded::due_passes::WrittenBuffer;
use crate::executor::loaded::residency::{ImageBinding, Residency};
use crate::store::{self, Stored};

impl Executor {
    /// Makes an executor that shares what is compiled, on any thread.
    pub(super) fn other(&self) -> impl FnOnce() -> Self + Send + use<> {
        let (compiler, queue, caps) = (self.compiler.clone(), self.queue.clone(), self.caps.clone());
        let labeled = self.labeled;
        move || {
            let mut other = Self::with_caps(&compiler.device, &queue, caps);
            other.compiler.pipelines = compiler.pipelines;
            other.compiler.compiled = compiler.compiled;
            other.compiler.pool = compiler.pool;
            other.labeled = labeled;
            other
        }
    }

    /// Makes, on any thread, an executor with memory of its own for a plan that this one has compiled.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn fork(&self) -> impl FnOnce(Arc<Plan>, Vec<u8>) -> Result<Self, GpuError> + Send + use<> {
        let other = self.other();
        move |plan, uniforms| {
            let mut fork = other();
            fork.load_with(plan, uniforms)?;
            Ok(fork)
        }
    }

    /// Continues the frames of an executor with the same plan: takes its frame number and uniforms. Histories are
    /// copied by [`copy_memory`](Self::copy_memory).
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn adopt_state(&mut self, other: &Self, uniforms: &[u8]) {
        self.frames.continue_from(&other.frames);
        if let Some(loaded) = &mut self.loaded {
            // It is copied.
            loaded.uninitialized.clear();
        }
        self.set_uniforms(0, uniforms);
    }

    /// The memory of the plan in use.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn residency(&self) -> Option<&Arc<Residency>> {
        self.loaded.as_ref().map(|loaded| &loaded.residency)
    }

    /// True if a frame was recorded and dropped on which later ones rely.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn has_lost_frames(&self) -> bool {
        self.recorded.take_lost() > Lost::Nothing
    }

    /// Copies histories, and buffers that outlive frames, from the memory of the same plan in another executor.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn copy_memory(&self, from: &Residency, encoder: &mut CommandEncoder) {
        let Some(loaded) = &self.loaded else { return };
        self.recorded.watch(encoder, Lost::State);
        for &WrittenBuffer { index, .. } in &loaded.persistent {
            encoder.copy_buffer_to_buffer(&from.buffers[index], 0, &loaded.residency.buffers[index], 0, None);
        }
        let rings = from.histories().zip(loaded.residency.histories());
        for (from, to) in rings.flat_map(|(from, to)| from.iter().zip(to)) {
            store::copy(from, to, encoder);
        }
    }

    /// Drops the bind groups of frames that write an output to a texture of ours.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn drop_bind_groups_of_own_outputs(&mut self) {
        let Some(Loaded { plan, residency, bind_groups, .. }) = &mut self.loaded else { return };
        let mut ours: Vec<&TextureView> = Vec::new();
        for output in &plan.outputs {
            if let ImageBinding::Output(_, stored) = &residency.bindings[output.image.0 as usize] {
                ours.push(&stored.view);
            }
        }
        bind_groups.retain(|groups| !groups.views[plan.inputs.len()..].iter().any(|view| ours.contains(&view)));
    }

    /// True if the next frame resets histories.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn is_fresh(&self) -> bool {
        self.frames.is_fresh
    }

    /// The format of the host's view for an output, as it is drawn to.
    ///
    /// # Errors
    /// It cannot be drawn to, or the device would encode it a second time.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn format_of(
        &mut self,
        output: &PlanOutput,
        view: &TextureView,
        frame: &Frame<'_>,
    ) -> Result<TextureFormat, GpuError> {
        let (device, stated) = (&self.compiler.device, frame.stated_format(&output.name));
        let format = self.host.formats.of_view(device, &output.name, view, stated)?;
        check_encoding(output, Some(format), view.texture().format())?;
        Ok(format)
    }

    /// The format of the host's view for an output in the last frame that drew it; the planned one if a pass stores to
    /// the view.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn last_format(&self, plan: &Plan, output: &PlanOutput) -> TextureFormat {
        let drawn = self.host.formats.last().iter().find(|(name, _)| *name == output.name).map(|(_, format)| *format);
        drawn.unwrap_or_else(|| texture_format(plan.image(output.image).desc.format))
    }

    /// True if the host fills passes of a plan.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn has_host_draws(plan: &Plan) -> bool {
        plan.work().any(|pass| host_node(pass).is_some())
    }
}

impl Residency {
    /// The rings of all histories, in the order of the plan's images.
    fn histories(&self) -> impl Iterator<Item = &[Stored]> {
        self.bindings.iter().filter_map(|binding| match binding {
            ImageBinding::Ring(ring, 0) => Some(ring.as_slice()),
            _ => None,
        })
    }

    /// True if all histories can be copied: nothing is copied to a depth or to several samples.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn can_be_copied(&self) -> bool {
        self.histories().flatten().all(|stored| stored.texture.usage().contains(TextureUsages::COPY_DST))
    }
}
