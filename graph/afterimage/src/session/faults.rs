//! Faults of functions of kinds in folders, and errors of baked LUTs, counted by a plan of its own.

use afterimage_gpu::{FrameStep, InputImage, KernelFaults};
use afterimage_graph::image::Size;
use afterimage_plan::Options;

use super::Session;
use crate::error::PostError;

/// The differences between a baked LUT and the nodes in whose place it is.
pub struct LutErrors {
    /// The largest difference of a channel for each of 2^18 random colors of each of [`GAMUTS`](Self::GAMUTS), in
    /// ascending order. A LUT that begins with display colors has them from the gamut of the display alone.
    pub colors: [Vec<f32>; 4],
    /// The green of nodes and of the LUT for each of 2^16 grays, from dark to bright.
    pub grays: Vec<[f32; 2]>,
}

impl LutErrors {
    const GRAYS: usize = 1 << 16;
    /// The gamuts of the random colors.
    pub const GAMUTS: [&'static str; 4] = ["Rec.709", "P3", "Rec.2020", "AP1"];
}

/// The faults of functions of kinds in folders in a frame that starts histories; empty without such kinds. The frame is
/// rendered once more, by a plan in which each such function runs twice; `session` does not change.
///
/// # Errors
/// As [`Session::render`].
pub fn kernel_faults(session: &mut Session, size: Size, images: &[InputImage]) -> Result<Vec<KernelFaults>, PostError> {
    if !session.load(size, images)?.has_untrusted_kernels() {
        return Ok(Vec::new());
    }
    let mut counting = counting(session, size, images)?;
    let plan = counting.plan().clone();
    let mut found: Vec<KernelFaults> = Vec::new();
    for counter in plan.fault_counters() {
        // A function may be called for each level of a pyramid.
        KernelFaults::count(&counting.output(counter.output)?, &counter, session.post.graph()).add_to(&mut found);
    }
    found.retain(KernelFaults::is_any);
    Ok(found)
}

/// The errors of each baked LUT, in the order of [`Savings::baked`](afterimage_plan::Savings::baked). A frame is
/// rendered once more, and `session` does not change.
///
/// # Errors
/// As [`Session::render`].
pub fn lut_errors(session: &mut Session, size: Size, images: &[InputImage]) -> Result<Vec<LutErrors>, PostError> {
    if session.load(size, images)?.savings.baked.is_empty() {
        return Ok(Vec::new());
    }
    let mut counting = counting(session, size, images)?;
    let baked = counting.plan().savings.baked.clone();
    let mut all = Vec::new();
    for output in baked.iter().filter_map(|baked| baked.error.as_deref()) {
        let mut pixels = counting.output(output)?.to_floats();
        let grays = pixels.split_off(pixels.len() - LutErrors::GRAYS);
        let colors = [0, 1, 2, 3].map(|gamut| {
            let of_gamut = pixels.chunks(pixels.len() / LutErrors::GAMUTS.len()).nth(gamut).unwrap_or_default();
            let mut colors: Vec<f32> = of_gamut.iter().map(|pixel| pixel[0]).collect();
            colors.sort_by(f32::total_cmp);
            colors
        });
        all.push(LutErrors { colors, grays: grays.iter().map(|pixel| [pixel[1], pixel[2]]).collect() });
    }
    Ok(all)
}

/// A session that has rendered a first frame with fault counters.
fn counting(session: &Session, size: Size, images: &[InputImage]) -> Result<Session, PostError> {
    let (graph, facts) = (session.post.graph().clone(), session.post.facts().clone());
    let options = Options { count_faults: true, ..session.plan().options };
    let mut counting = Session::new(&session.gpu, graph, facts, options);
    counting.uploads.blocks.clone_from(&session.uploads.blocks);
    counting.render(size, images, FrameStep::FIRST)?;
    Ok(counting)
}
