//! Faults of functions of kinds in folders, and errors of color tables, counted by a plan of its own.

use afterimage_gpu::{FrameStep, InputImage, KernelFaults};
use afterimage_graph::image::Size;
use afterimage_plan::Options;

use super::Session;
use crate::error::PostError;

/// The differences between a table of colors and the nodes in whose place it is.
pub struct TableErrors {
    /// The largest difference of a channel for each of 2^20 random colors, in ascending order.
    pub colors: Vec<f32>,
    /// The green of nodes and of the table for each of 2^16 grays, from dark to bright.
    pub grays: Vec<[f32; 2]>,
}

impl TableErrors {
    const GRAYS: usize = 1 << 16;
}

impl Session {
    /// The faults of functions of kinds in folders in a frame that starts histories; empty without such kinds. The
    /// frame is rendered once more, by a plan in which each such function runs twice; this session does not change.
    ///
    /// # Errors
    /// As [`render`](Session::render).
    pub fn kernel_faults(&mut self, size: Size, images: &[InputImage]) -> Result<Vec<KernelFaults>, PostError> {
        let plan = self.load(size, images)?.clone();
        if !plan.has_untrusted_kernels() {
            return Ok(Vec::new());
        }
        let mut probing = self.probing(size, images)?;
        let plan = probing.plan().clone();
        let mut found: Vec<KernelFaults> = Vec::new();
        for counter in plan.fault_counters() {
            // A function may be called for each level of a pyramid.
            KernelFaults::count(&probing.output(counter.output)?, &counter, self.post.graph()).add_to(&mut found);
        }
        found.retain(KernelFaults::is_any);
        Ok(found)
    }

    /// The errors of each table of colors, in the order of [`Plan::baked`](afterimage_plan::Plan::baked). A
    /// frame is rendered once more, and this session does not change.
    ///
    /// # Errors
    /// As [`render`](Session::render).
    pub fn table_errors(&mut self, size: Size, images: &[InputImage]) -> Result<Vec<TableErrors>, PostError> {
        if self.load(size, images)?.savings.baked.is_empty() {
            return Ok(Vec::new());
        }
        let mut probing = self.probing(size, images)?;
        let baked = probing.plan().savings.baked.clone();
        let mut all = Vec::new();
        for output in baked.iter().filter_map(|baked| baked.error.as_deref()) {
            let mut pixels = probing.output(output)?.to_floats();
            let grays = pixels.split_off(pixels.len() - TableErrors::GRAYS);
            let mut colors: Vec<f32> = pixels.iter().map(|pixel| pixel[0]).collect();
            colors.sort_by(f32::total_cmp);
            all.push(TableErrors { colors, grays: grays.iter().map(|pixel| [pixel[1], pixel[2]]).collect() });
        }
        Ok(all)
    }

    /// A session that has rendered a first frame with fault counters.
    fn probing(&self, size: Size, images: &[InputImage]) -> Result<Self, PostError> {
        let (graph, facts) = (self.post.graph().clone(), self.post.facts().clone());
        let options = Options { count_faults: true, ..self.plan().options };
        let mut probing = Self::new(&self.gpu, graph, facts, options);
        probing.blocks.clone_from(&self.blocks);
        probing.render(size, images, FrameStep::FIRST)?;
        Ok(probing)
    }
}
