//! The frame time of `bench`, `measure` and `tune`: one function, so that they agree on a plan.

use afterimage::offline::Session;
use afterimage_gpu::{Clock, FrameKind, FrameStep, FrameTime, InputImage};

use crate::LabError;

/// Seconds between two frames.
const STEP: f32 = 1.0 / 60.0;

/// The time of a frame of the loaded plan with these images. It runs with fresh allocations: their addresses change the
/// time by several percent, and would otherwise depend on earlier plans.
pub(crate) fn frame_time(
    session: &Session,
    clock: &Clock,
    samples: u32,
    images: &[InputImage],
) -> Result<FrameTime, LabError> {
    let mut session = session.clone_with_fresh_allocations(images)?;
    let mut frames = 0;
    let (time, _) = session.frame_time(clock, samples, images, &mut || next_step(&mut frames), Vec::new())?;
    Ok(time)
}

/// The position of the next frame in time.
pub(crate) fn next_step(frames: &mut u32) -> FrameStep {
    let (number, reset) = (*frames, *frames == 0);
    *frames += 1;
    FrameStep { time: number as f32 * STEP, dt: if reset { 0.0 } else { STEP }, kind: FrameKind::cut_if(reset) }
}
