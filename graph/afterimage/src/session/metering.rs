//! Frames that are measured in any order, and the state that follows from what was measured.

use afterimage_gpu::internal::{caught, submit};
use afterimage_gpu::{FrameStep, GpuError, InputImage};
use afterimage_plan::Metering;

use super::Session;

/// Measures a frame of the loaded plan: runs the passes that measure and no other. Returns the bytes of each buffer of
/// [`Metering::measured`]. Waits for the GPU.
///
/// # Errors
/// As [`Session::encode`].
///
/// # Panics
/// If nothing was loaded yet, or if the meters are those of another plan.
pub fn measure(
    session: &mut Session,
    metering: &Metering,
    images: &[InputImage],
    step: FrameStep,
) -> Result<Vec<Vec<u8>>, GpuError> {
    submit_passes(session, images, step, &metering.measuring)?;
    let mut measured = Vec::new();
    for id in &metering.measured {
        let length = session.plan().buffers[id.0 as usize].bytes;
        let buffer = session.post.executor().loaded().expect("a plan is loaded").plan_buffer(*id).clone();
        let mut bytes = session.readback.bytes(&buffer, buffer.size())?;
        bytes.truncate(length as usize);
        measured.push(bytes);
    }
    Ok(measured)
}

/// Puts what was measured in a frame together with the state before it, which is reset if `step` resets: after it the
/// state of [`Metering::state`] is that after the frame. Other state is as before. `images` are bound and not read:
/// those of any frame.
///
/// # Errors
/// As [`Session::encode`].
///
/// # Panics
/// If nothing was loaded yet, or if the meters are those of another plan.
pub fn integrate(
    session: &mut Session,
    metering: &Metering,
    images: &[InputImage],
    step: FrameStep,
    measured: &[Vec<u8>],
) -> Result<(), GpuError> {
    assert_eq!(metering.measured.len(), measured.len(), "the meters are those of another plan");
    for (id, bytes) in metering.measured.iter().zip(measured) {
        let buffer = session.post.executor().loaded().expect("a plan is loaded").plan_buffer(*id);
        caught("what was measured", || session.gpu.queue.write_buffer(buffer, 0, bytes))?;
    }
    submit_passes(session, images, step, &metering.integrating)
}

fn submit_passes(
    session: &mut Session,
    images: &[InputImage],
    step: FrameStep,
    passes: &[usize],
) -> Result<(), GpuError> {
    let Session { gpu, post, uploads, .. } = session;
    submit(&gpu.device, &gpu.queue, "the passes of meters", |encoder| {
        uploads.with_frame(images, step, |frame| post.executor().encode_passes(encoder, frame, passes))
    })
}
