//! Counts NaN and ended loops of kinds in folders, which the picture does not show because they are replaced.

use std::sync::Arc;

use afterimage_gpu::{FrameKind, Gpu, KernelFaults, wgpu};
use afterimage_plan::Plan;

use super::{FrameImages, Moment, PipelineInstance, PlanPreset};
use crate::Problem;
use crate::render::ImageCopy;

/// Counts once for each plan of the shown picture: a pipeline with fault counters renders one frame, and its counts are
/// read when they have arrived.
#[derive(Default)]
pub(super) struct FaultCount {
    counting: Option<PipelineInstance>,
    /// The shown plan for which faults are counted.
    counted: Option<Arc<Plan>>,
    is_due: bool,
    /// The plan with fault counters and its outputs, on their way from the device.
    arriving: Option<(Arc<Plan>, Vec<ImageCopy>)>,
    found: Vec<KernelFaults>,
}

impl FaultCount {
    pub(super) fn found(&self) -> &[KernelFaults] {
        &self.found
    }

    /// The pipeline with fault counters, if there is one.
    pub(super) fn instance(&mut self) -> impl Iterator<Item = &mut PipelineInstance> {
        self.counting.iter_mut()
    }

    /// True if a frame must be recorded, or counts have not arrived.
    pub(super) fn is_busy(&self) -> bool {
        self.is_due || self.arriving.is_some()
    }

    /// Takes counts that have arrived. Call it before a frame is recorded, when the commands of the last are submitted.
    pub(super) fn take(&mut self, gpu: &Gpu) {
        let Some((plan, copies)) = &mut self.arriving else { return };
        for copy in copies.iter_mut() {
            copy.request();
        }
        // Mapped buffers arrive while the device is polled, and nothing waits for them.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let Some(texels) = copies.iter().map(ImageCopy::texels).collect::<Option<Vec<_>>>() else { return };
        if let Some(counting) = &self.counting {
            for (counter, texels) in plan.fault_counters().zip(&texels) {
                KernelFaults::count(texels, &counter, counting.graph()).add_to(&mut self.found);
            }
        }
        self.found.retain(KernelFaults::is_any);
        self.arriving = None;
    }

    /// Records the frame with fault counters, if the shown plan is new and its kinds are not all built in.
    pub(super) fn record(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        shown: &PipelineInstance,
        images: &FrameImages,
    ) -> Result<(), Problem> {
        let Some(plan) = shown.plan().filter(|_| !shown.is_changing()) else { return Ok(()) };
        if !self.counted.as_ref().is_some_and(|counted| Arc::ptr_eq(counted, plan)) {
            let is_due = plan.has_untrusted_kernels();
            let counting = self.counting.take().filter(|_| is_due);
            *self = Self { counting, counted: Some(plan.clone()), is_due, ..Self::default() };
        }
        if !self.is_due {
            return Ok(());
        }
        let counting = self.counting.get_or_insert_with(|| {
            PipelineInstance::new(gpu, shown.graph().clone(), shown.facts().clone(), PlanPreset::CountFaults)
        });
        counting.frame(encoder, images, Moment { kind: FrameKind::Cut, ..Moment::default() })?;
        if counting.is_changing() {
            return Ok(());
        }
        let Some(plan) = counting.plan().cloned() else { return Ok(()) };
        let mut copies = Vec::new();
        for counter in plan.fault_counters() {
            copies.extend(ImageCopy::record(&gpu.device, encoder, counting.output_texture(counter.output), 0));
        }
        self.arriving = Some((plan, copies));
        self.is_due = false;
        Ok(())
    }
}
