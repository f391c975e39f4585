//! Times of the loaded plan. All tools time with these functions, so that they report the same quantities.

use afterimage_gpu::{Clock, FrameKind, FrameStep, FrameTime, GpuError, InputImage, LoadedPlan, TimedCommands, median};

use super::Session;

/// Seconds between two timed frames.
const STEP: f32 = 1.0 / 60.0;

/// The position in time of the timed frame of this number.
pub fn timed_step(number: u32) -> FrameStep {
    let is_first = number == 0;
    FrameStep {
        time: f64::from(number) * f64::from(STEP),
        dt: if is_first { 0.0 } else { STEP },
        kind: FrameKind::cut_if(is_first),
    }
}

/// The time of a frame of a sequence: timestamps around the whole frame, as [`Clock`] defines it. Where passes do not
/// run in every frame, it is the mean of a [cycle](afterimage_plan::Plan::refresh_cycle). `baselines` are other work
/// that is timed under the same conditions.
///
/// # Errors
/// See [`Clock::medians`].
pub fn frame_time<'r>(
    session: &'r mut Session,
    clock: &Clock,
    samples: u32,
    images: &'r [InputImage],
    baselines: Vec<TimedCommands<'r>>,
) -> Result<(FrameTime, Vec<FrameTime>), GpuError> {
    let cycle = session.plan().refresh_cycle();
    let mut numbers = 0..;
    let frame: TimedCommands<'r> = Box::new(move |encoder| {
        let mut numbers = numbers.by_ref().take(cycle as usize);
        numbers.try_for_each(|number| session.encode(encoder, images, timed_step(number)))
    });
    let mut work: Vec<TimedCommands<'r>> = [frame].into_iter().chain(baselines).collect();
    let mut times = clock.medians(samples, &mut work)?.into_iter();
    let frame = times.next().expect("one time for each recording").divided(cycle);
    Ok((frame, times.collect()))
}

/// Median milliseconds of each pass: by timestamps between the passes, or, where timestamps cannot be trusted, of each
/// pass submitted alone.
///
/// The sum is more than [`frame_time`], because passes of one batch do not overlap here, and each frame also runs the
/// passes that run after a change of their uniforms.
///
/// # Errors
/// See [`Session::encode`] and [`Clock::medians`].
pub fn pass_times(
    session: &mut Session,
    clock: &Clock,
    samples: u32,
    images: &[InputImage],
) -> Result<Vec<f64>, GpuError> {
    if !clock.is_gpu() || !session.post.executor().enable_timing()? {
        return times_alone(session, clock, samples, images, timed_step(1));
    }
    let mut all = vec![Vec::new(); session.plan().passes.len()];
    for number in 1..=samples {
        session.post.executor().loaded_mut().into_iter().for_each(LoadedPlan::force_on_change);
        let times = times_within(session, images, timed_step(number))?;
        all.iter_mut().zip(times).for_each(|(samples, time)| samples.push(time));
    }
    Ok(all.into_iter().map(median).collect())
}

/// Milliseconds of each pass of one frame by timestamps. `None` where the device has none inside passes, and on a
/// processor, whose drivers count what a pass draws as time of a later one.
///
/// # Errors
/// See [`Session::encode`].
pub fn pass_times_once(
    session: &mut Session,
    images: &[InputImage],
    step: FrameStep,
) -> Result<Option<Vec<f64>>, GpuError> {
    if session.gpu.is_processor() || !session.post.executor().enable_timing()? {
        return Ok(None);
    }
    times_within(session, images, step).map(Some)
}

fn times_within(session: &mut Session, images: &[InputImage], step: FrameStep) -> Result<Vec<f64>, GpuError> {
    session.submit(images, step)?;
    Ok(session.post.executor().loaded().map_or(Ok(None), LoadedPlan::pass_times)?.unwrap_or_default())
}

fn times_alone(
    session: &mut Session,
    clock: &Clock,
    samples: u32,
    images: &[InputImage],
    step: FrameStep,
) -> Result<Vec<f64>, GpuError> {
    let passes = 0..session.plan().passes.len();
    let Session { post, uploads, .. } = session;
    let mut alone = |pass| {
        let record = |encoder: &mut _| {
            uploads.with_frame(images, step, |frame| post.executor().encode_pass(encoder, frame, pass))
        };
        let work: TimedCommands<'_> = Box::new(record);
        Ok(clock.medians(samples, &mut [work])?[0].ms())
    };
    passes.map(&mut alone).collect()
}
