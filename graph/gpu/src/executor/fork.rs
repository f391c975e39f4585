//! A second executor that continues the plan in use while the first one runs the next plan, for a fade.

use std::sync::Arc;

use afterimage_plan::Plan;
use wgpu::{CommandEncoder, TextureUsages};

use super::Executor;
use super::frame::Frame;
use super::recorded::Lost;
use crate::error::GpuError;
use crate::executor::loaded::due_passes::WrittenBuffer;
use crate::executor::loaded::residency::{ImageBinding, Residency};
use crate::store::{self, Stored};

/// An executor that continues the plan of another one.
pub struct Fork {
    /// The executor.
    pub executor: Executor,
    /// The memory of the plan in the other executor, until it is copied.
    memory: Option<Arc<Residency>>,
}

impl Fork {
    /// Makes, on any thread, an executor with memory of its own for a plan that the other one has compiled.
    pub fn prepare(other: &Executor) -> impl FnOnce(Arc<Plan>, Vec<u8>) -> Result<Self, GpuError> + Send + use<> {
        let fork = other.sharing_compiled();
        move |plan, uniforms| {
            let mut executor = fork();
            executor.load_with(plan, uniforms)?;
            Ok(Self { executor, memory: None })
        }
    }

    /// Continues the frames of the other executor: its frame number, these uniforms, and the histories in `memory`.
    pub fn continue_from(&mut self, other: &Executor, memory: Arc<Residency>, uniforms: &[u8]) {
        self.executor.frames.continue_from(&other.frames);
        if let Some(loaded) = &mut self.executor.loaded {
            // It is copied.
            loaded.uninitialized.clear();
            loaded.set_uniforms(0, uniforms);
        }
        self.memory = Some(memory);
    }

    /// Records a frame. The first one copies histories, and buffers that outlive frames.
    ///
    /// # Errors
    /// As [`Executor::encode`].
    pub fn encode(&mut self, encoder: &mut CommandEncoder, frame: &Frame<'_>) -> Result<(), GpuError> {
        if let Some(memory) = self.memory.take() {
            self.copy_memory(&memory, encoder);
            self.executor.compiler.drop_later(memory);
        }
        self.executor.encode(encoder, frame)
    }

    fn copy_memory(&self, from: &Residency, encoder: &mut CommandEncoder) {
        let Some(loaded) = &self.executor.loaded else { return };
        self.executor.recorded.watch(encoder, Lost::State);
        for &WrittenBuffer { index, .. } in &loaded.persistent {
            encoder.copy_buffer_to_buffer(&from.buffers[index], 0, &loaded.residency.buffers[index], 0, None);
        }
        let rings = from.histories().zip(loaded.residency.histories());
        for (from, to) in rings.flat_map(|(from, to)| from.iter().zip(to)) {
            store::copy(from, to, encoder);
        }
    }

    /// True if a frame was recorded and dropped on which later ones rely.
    pub fn has_lost_frames(&self) -> bool {
        self.executor.recorded.take_lost() > Lost::Nothing
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
