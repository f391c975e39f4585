//! Counts NaN and ended loops of kinds in folders, which the picture does not show because they are replaced.

use std::sync::Arc;

use afterimage_gpu::{FrameKind, Gpu, KernelFaults, wgpu};
use afterimage_plan::Plan;

use super::chains::Chains;
use super::{Chain, FrameImages, Moment, Purpose};
use crate::Problem;
use crate::render::Copied;

/// Counts once for each plan of the shown picture: a pipeline with probes renders one frame, and its counts are read
/// when they have arrived.
#[derive(Default)]
pub(super) struct FaultCount {
    /// The shown plan for which faults are counted.
    counted: Option<Arc<Plan>>,
    is_due: bool,
    /// The plan with probes and its outputs, on their way from the device.
    arriving: Option<(Arc<Plan>, Vec<Copied>)>,
    found: Vec<KernelFaults>,
}

impl FaultCount {
    pub(super) fn found(&self) -> &[KernelFaults] {
        &self.found
    }

    /// Whether a frame must be recorded, or counts have not arrived.
    pub(super) fn is_busy(&self) -> bool {
        self.is_due || self.arriving.is_some()
    }

    /// Takes counts that have arrived. Call it before a frame is recorded, when the commands of the last are submitted.
    pub(super) fn take(&mut self, gpu: &Gpu, chains: &Chains) {
        let Some((plan, copies)) = &mut self.arriving else { return };
        for copy in copies.iter_mut() {
            copy.request();
        }
        // Mapped buffers arrive while the device is polled, and nothing waits for them.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let Some(texels) = copies.iter().map(Copied::texels).collect::<Option<Vec<_>>>() else { return };
        if let Some(counting) = &chains.counting {
            for (probe, texels) in plan.probes().zip(&texels) {
                KernelFaults::count(texels, &probe, counting.graph()).add_to(&mut self.found);
            }
        }
        self.found.retain(KernelFaults::is_any);
        self.arriving = None;
    }

    /// Records the frame with probes, if the shown plan is new and its kinds are not all built in.
    pub(super) fn record(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        chains: &mut Chains,
        images: &FrameImages,
    ) -> Result<(), Problem> {
        let Some(shown) = chains.shown.as_ref().filter(|shown| !shown.is_changing()) else { return Ok(()) };
        let Some(plan) = shown.plan() else { return Ok(()) };
        if !self.counted.as_ref().is_some_and(|counted| Arc::ptr_eq(counted, plan)) {
            let is_due = plan.has_untrusted_kernels();
            *self = Self { counted: Some(plan.clone()), is_due, ..Self::default() };
            match is_due {
                true if chains.counting.is_none() => chains.counting = Some(shown.counting(gpu)),
                true => {}
                false => chains.counting = None,
            }
        }
        let Some(counting) = chains.counting.as_mut().filter(|_| self.is_due) else { return Ok(()) };
        counting.frame(encoder, images, Moment { kind: FrameKind::Cut, ..Moment::default() })?;
        if counting.is_changing() {
            return Ok(());
        }
        let Some(plan) = counting.plan().cloned() else { return Ok(()) };
        let mut copies = Vec::new();
        for probe in plan.probes() {
            copies.extend(Copied::record(&gpu.device, encoder, counting.output_texture(probe.output), 0));
        }
        self.arriving = Some((plan, copies));
        self.is_due = false;
        Ok(())
    }
}

impl Chain {
    /// A pipeline with the same graph, values and facts that counts faults.
    fn counting(&self, gpu: &Gpu) -> Self {
        let mut counting = Self::new(gpu, self.graph().clone(), Purpose::CountFaults);
        counting.post().set_facts(self.facts().clone());
        counting
    }
}
