//! The frame time of `bench`, `measure` and `tune`: one function, so that they agree on a plan.

use afterimage::offline::{Session, timing};
use afterimage_gpu::{Clock, FrameTime, InputImage};

use crate::LabError;

/// The time of a frame of the plan that is loaded, on these images in every frame. It runs in memory of its own: where
/// images lie in memory changes the time by several percent, and would otherwise depend on the plans before.
pub(crate) fn frame_time(
    session: &Session,
    clock: &Clock,
    samples: u32,
    images: &[InputImage],
) -> Result<FrameTime, LabError> {
    let mut session = session.clone_with_fresh_allocations(images)?;
    Ok(timing::frame_time(&mut session, clock, samples, images, Vec::new())?.0)
}
