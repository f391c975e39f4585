//! Cross-fades: after a change in the background the old plan renders on for some frames, and each frame is a mix of
//! both.

mod mix;
mod skip_reason;

use std::sync::Arc;

use afterimage_graph::image::Size;
use afterimage_graph::node::Resource;
use afterimage_plan::{Plan, PlanOutput};
use wgpu::{BindGroup, CommandEncoder, TextureUsages, TextureView};

use super::active::ActivePlan;
use super::live_graph::GraphValues;
use crate::error::GpuError;
use crate::executor::{Executor, Frame, FrameKind, HostDraw, Rectangle, Residency};
use crate::platform::{scoped, watched};
pub(super) use mix::FadeParts;
use mix::{Mixer, Target};
pub use skip_reason::FadeSkipReason;

/// The longest fade: the shader has 16 bits for its frames.
const MAX_FRAMES: u16 = u16::MAX - 1;
const WHAT: &str = "the mix of a fade";

/// How changes are faded, and the present fade.
#[derive(Default)]
pub(super) struct Fade {
    /// Frames of each fade; 0 for none.
    frames: u16,
    running: Option<RunningFade>,
    /// Why the last change was not faded.
    pub(super) skip_reason: Option<FadeSkipReason>,
}

/// What a fade starts with: its parts, and the memory of the old plan.
pub(super) struct FadeStart {
    parts: FadeParts,
    memory: Arc<Residency>,
}

/// An old plan that renders next to the new one.
struct RunningFade {
    parts: FadeParts,
    old: ActivePlan,
    /// The memory of the old plan, until it is copied.
    memory: Option<Arc<Residency>>,
    /// Binds the outputs of both plans.
    outputs: BindGroup,
    /// The number of the next frame, from 1, and the number of frames.
    number: u16,
    frames: u16,
}

impl Fade {
    /// Sets the frames of the next fades.
    pub(super) fn set_frames(&mut self, frames: u16) {
        self.frames = frames.min(MAX_FRAMES);
    }

    /// The same setting for another view.
    pub(super) fn for_view(&self) -> Self {
        Self { frames: self.frames, ..Self::default() }
    }

    pub(super) fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Whether a frame of the old plan was dropped on which later ones rely.
    pub(super) fn has_lost_frames(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.parts.fork.has_lost_frames())
    }

    /// The revision of the graph of the old plan that renders.
    pub(super) fn old_revision(&self) -> Option<u64> {
        self.running.as_ref().map(|running| running.old.revision())
    }

    /// Updates the old plan to the present values of its graph. Where one needs another plan, it keeps its own.
    pub(super) fn update_old(&mut self, values: GraphValues<'_>) {
        if let Some(running) = &mut self.running {
            let _ = running.old.update(values);
        }
    }

    /// Remembers why a change is not faded, if changes are.
    pub(super) fn skip(&mut self, why: FadeSkipReason) {
        self.skip_reason = (self.frames > 0).then_some(why);
    }

    /// Ends the present fade: the new plan renders alone from the next frame on.
    pub(super) fn end(&mut self, executor: &mut Executor, why: FadeSkipReason) {
        if let Some(running) = self.running.take() {
            release(running, executor);
            self.skip_reason = Some(why);
        }
    }

    /// What prepares a fade from the active plan, on any thread; `None` if changes are not faded.
    pub(super) fn preparation(
        &self,
        executor: &Executor,
        active: &ActivePlan,
    ) -> Option<impl FnOnce() -> Result<FadeParts, FadeSkipReason> + Send + use<>> {
        if self.frames == 0 {
            return None;
        }
        let format = executor.last_format(&active.plan, output_of(&active.plan).ok()?);
        let (fork, plan, uniforms) = (executor.fork(), active.plan.clone(), active.uniforms.clone());
        let device = executor.device().clone();
        Some(move || {
            let mixer = watched(&device, WHAT, || Ok(Mixer::new(&device, format))).map_err(refused)?;
            Ok(FadeParts { fork: fork(plan, uniforms).map_err(refused)?, mixer })
        })
    }

    /// What a fade from one plan to another starts with, before the new one is installed; or why the change is not
    /// faded. `None` if changes are not.
    pub(super) fn before_change(
        &self,
        executor: &Executor,
        old: Option<&ActivePlan>,
        new: &Plan,
        frame: Option<&Frame<'_>>,
        parts: Option<Result<FadeParts, FadeSkipReason>>,
    ) -> Option<Result<FadeStart, FadeSkipReason>> {
        let memory = if self.frames > 0 { Some(memory_to_fade(executor, old, new, frame)) } else { None };
        match (memory, parts) {
            (Some(Ok(memory)), Some(parts)) => Some(parts.map(|parts| FadeStart { parts, memory })),
            (Some(Ok(_)), None) => Some(Err(FadeSkipReason::Late)),
            (memory, parts) => {
                if let Some(Ok(parts)) = parts {
                    executor.drop_later(parts);
                }
                memory.and_then(Result::err).map(Err)
            }
        }
    }

    /// Starts a fade from the old plan, after the new one is installed. Returns the old plan if it is not faded.
    pub(super) fn start(
        &mut self,
        executor: &Executor,
        start: Option<Result<FadeStart, FadeSkipReason>>,
        old: ActivePlan,
    ) -> Option<ActivePlan> {
        self.skip_reason = None;
        match start {
            None => {}
            Some(Err(why)) => self.skip(why),
            Some(Ok(FadeStart { mut parts, memory })) => {
                parts.fork.adopt_state(executor, &old.uniforms);
                match bind_outputs(executor, &parts, &old) {
                    Ok(outputs) => {
                        let (memory, number, frames) = (Some(memory), 1, self.frames);
                        self.running = Some(RunningFade { parts, old, memory, outputs, number, frames });
                        return None;
                    }
                    Err(error) => self.skip(refused(error)),
                }
            }
        }
        Some(old)
    }

    /// Records the frame of the loaded plan; or, during a fade, those of the old and the new plan and their mix. If the
    /// old plan cannot be recorded, the fade ends.
    pub(super) fn record(
        &mut self,
        executor: &mut Executor,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        draws: &mut [HostDraw<'_>],
    ) -> Result<(), GpuError> {
        let Some(mut running) = self.running.take() else {
            return executor.encode_drawing(encoder, frame, draws);
        };
        let target = match running.record_old(executor, encoder, frame) {
            Ok(target) => target,
            Err(why) => {
                release(running, executor);
                self.skip_reason = Some(why);
                return executor.encode_drawing(encoder, frame, draws);
            }
        };
        executor.encode_drawing(encoder, &Frame { outputs: &[], ..*frame }, draws)?;
        running.parts.mixer.record(encoder, &running.outputs, &target, running.number, running.frames);
        running.number += 1;
        if running.number > running.frames {
            release(running, executor);
        } else {
            self.running = Some(running);
        }
        Ok(())
    }
}

impl RunningFade {
    /// Records the old plan. Returns where the mix is drawn, or why the fade ends.
    fn record_old<'f>(
        &mut self,
        executor: &mut Executor,
        encoder: &mut CommandEncoder,
        frame: &Frame<'f>,
    ) -> Result<Target<'f>, FadeSkipReason> {
        let output = output_of(&self.old.plan)?;
        let (view, rectangle) = view_to_draw(frame, &output.name)?;
        let size = frame.size_of(&output.name, view);
        let part = rectangle.unwrap_or(Rectangle::whole(size));
        if !part.lies_in(size) || part.size() != size_of(&self.old.plan, output) {
            return Err(FadeSkipReason::NewImages);
        }
        let format = executor.format_of(output, view, frame).map_err(refused)?;
        self.continue_old(executor, format, encoder, frame).map_err(refused)?;
        Ok(Target { view, rectangle })
    }

    fn continue_old(
        &mut self,
        executor: &Executor,
        format: wgpu::TextureFormat,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<(), GpuError> {
        let device = executor.device();
        if self.parts.mixer.format != format {
            self.parts.mixer = watched(device, WHAT, || Ok(Mixer::new(device, format)))?;
            self.outputs = bind_outputs(executor, &self.parts, &self.old)?;
        }
        let fork = &mut self.parts.fork;
        self.old.write(fork);
        if let Some(memory) = self.memory.take() {
            fork.copy_memory(&memory, encoder);
            executor.drop_later(memory);
        }
        fork.encode(encoder, &Frame { outputs: &[], ..*frame })
    }
}

/// Drops the old plan and the resources of a fade.
fn release(running: RunningFade, executor: &mut Executor) {
    executor.drop_later(running);
    executor.drop_bind_groups_of_own_outputs();
}

/// The memory of the plan that renders, if the change to another one in this frame can be faded.
fn memory_to_fade(
    executor: &Executor,
    old: Option<&ActivePlan>,
    new: &Plan,
    frame: Option<&Frame<'_>>,
) -> Result<Arc<Residency>, FadeSkipReason> {
    let old = &old.ok_or(FadeSkipReason::NewBeginning)?.plan;
    let frame = frame.ok_or(FadeSkipReason::Awaited)?;
    let old_output = output_of(old)?;
    let new_output = output_of(new)?;
    if old_output.name != new_output.name || size_of(old, old_output) != size_of(new, new_output) {
        return Err(FadeSkipReason::Outputs);
    }
    // A host may have loaded another plan into the executor.
    let is_loaded = executor.plan().is_some_and(|plan| Arc::ptr_eq(plan, old));
    if !is_loaded || frame.kind == FrameKind::Cut || executor.is_fresh() {
        return Err(FadeSkipReason::NewBeginning);
    }
    let memory = executor.residency().ok_or(FadeSkipReason::NewBeginning)?;
    if !memory.can_be_copied() {
        return Err(FadeSkipReason::DepthHistory);
    }
    view_to_draw(frame, &old_output.name)?;
    Ok(memory.clone())
}

/// The bind group of the outputs of both plans.
fn bind_outputs(executor: &Executor, parts: &FadeParts, old: &ActivePlan) -> Result<BindGroup, GpuError> {
    let name = &old.plan.outputs[0].name;
    let before = parts.fork.output(name).ok_or(GpuError::NoPlan)?;
    let after = executor.output(name).ok_or(GpuError::NoPlan)?;
    let device = executor.device();
    scoped(device, WHAT, || Ok(parts.mixer.bind_group(device, before, after)))
}

/// The output of a plan that can be faded.
fn output_of(plan: &Plan) -> Result<&PlanOutput, FadeSkipReason> {
    let [output] = plan.outputs.as_slice() else { return Err(FadeSkipReason::Outputs) };
    let image = Resource::Image(output.image);
    if Executor::has_host_draws(plan) {
        return Err(FadeSkipReason::HostDraws);
    }
    if plan.work().any(|pass| pass.reads().contains(&image)) {
        return Err(FadeSkipReason::OutputIsRead);
    }
    Ok(output)
}

fn size_of(plan: &Plan, output: &PlanOutput) -> Size {
    plan.image(output.image).desc.size
}

/// The host's only view, for this output, and its rectangle, if it can be drawn to.
fn view_to_draw<'f>(frame: &Frame<'f>, name: &str) -> Result<(&'f TextureView, Option<Rectangle>), FadeSkipReason> {
    let [(known, view)] = frame.outputs else { return Err(FadeSkipReason::NotDrawable) };
    let can_be_drawn = *known == name && view.texture().usage().contains(TextureUsages::RENDER_ATTACHMENT);
    if can_be_drawn { Ok((view, frame.rectangle(name))) } else { Err(FadeSkipReason::NotDrawable) }
}

fn refused(error: GpuError) -> FadeSkipReason {
    FadeSkipReason::Refused(error.to_string())
}
