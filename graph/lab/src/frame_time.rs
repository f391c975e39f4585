//! The frame time of `bench`, `measure` and `tune`: one function, so that they agree on a plan.

use afterimage::offline::{Session, timing};
use afterimage_gpu::{Clock, FrameTime, InputImage};

use crate::LabError;

/// The time of a frame of the loaded plan with these images. It runs with fresh allocations: their addresses change the
/// time by several percent, and would otherwise depend on earlier plans.
pub(crate) fn frame_time(
    session: &Session,
    clock: &Clock,
    samples: u32,
    images: &[InputImage],
) -> Result<FrameTime, LabError> {
    let mut session = session.clone_with_fresh_allocations(images)?;
    Ok(timing::frame_time(&mut session, clock, samples, images, Vec::new())?.0)
}
