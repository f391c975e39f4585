//! Cross-fades: after a change in the background the old plan renders on for some frames, and each frame is a mix of
//! both.

use std::sync::Arc;

use afterimage_graph::image::Size;
use afterimage_graph::node::Resource;
use afterimage_plan::{Plan, PlanOutput};
use wgpu::{BindGroup, CommandEncoder, TextureUsages, TextureView};

use super::fade_skip_reason::FadeSkipReason;
use super::fading::{Beginning, Fading};
use super::mix::{FadeParts, Mixer, Target};
use super::running::ActivePlan;
use super::{Post, PostError};
use crate::executor::Residency;
use crate::platform::{scoped, watched};
use crate::{Executor, Frame, GpuError, HostDraw, Rectangle};

/// The most frames of a fade: the shader has 16 bits for them.
const MOST: u16 = u16::MAX - 1;
const WHAT: &str = "the mix of a fade";

impl Post {
    /// Fades from the old plan to the new one over this many frames after each change that is made in the background,
    /// at most 65,534; 0, the default, changes at once. Both plans render in these frames, each with histories and
    /// adaptation that go on, and frame `k` of `n` has `k / (n + 1)` of the new picture: of its codes where the host's
    /// image holds codes, of its light where it holds light. The frame before them is of the old plan alone, and the
    /// frame after them of the new plan alone, bit for bit what it would be without a fade.
    ///
    /// In these frames the old plan has memory of its own beside that of the new one, which is made in the background
    /// with the new plan, and a second executor; the next frame has neither. Values of parameters change both pictures.
    /// A change that is ready waits for the end of a fade, so that no picture jumps. A reset, another size or other
    /// images of the host, [`finish_changes`](Self::finish_changes) and [`rebuild`](Self::rebuild) end a fade at once.
    /// [`fade_skip_reason`](Self::not_faded) says why a change came in at once.
    ///
    /// The number holds for the next changes, here and in views that [`another`](Self::another) makes from now on.
    pub fn set_fade(&mut self, frames: u16) {
        self.fade.frames = frames.min(MOST);
    }

    /// Whether the next frame is a mix of two plans, unless something ends the fade.
    pub fn is_fading(&self) -> bool {
        self.fade.goes_on()
    }

    /// Why the last change was not faded, or not to its end. `None` if it was, if there was none, and without
    /// [`set_fade`](Self::set_fade).
    pub fn fade_skip_reason(&self) -> Option<&FadeSkipReason> {
        self.fade.missed.as_ref()
    }

    /// What makes the parts of a fade from the plan that renders, on any thread; `None` if changes are not faded.
    pub(super) fn fade_parts(&self) -> Option<impl FnOnce() -> Result<FadeParts, FadeSkipReason> + Send + use<>> {
        let running = self.running.as_ref().filter(|_| self.fade.frames > 0)?;
        let format = self.executor.last_format(&running.plan, output_of(&running.plan).ok()?);
        let (double, wanted) = (self.executor.fork(), running.wanted());
        let device = self.executor.device().clone();
        Some(move || {
            let mixer = watched(&device, WHAT, || Ok(Mixer::new(&device, format))).map_err(refused)?;
            Ok(FadeParts { double: double(wanted).map_err(refused)?, mixer })
        })
    }

    /// What a fade to a plan begins with, before it comes in; or why it is not faded. `None` if changes are not.
    pub(super) fn beginning(
        &self,
        new: &Plan,
        frame: Option<&Frame<'_>>,
        parts: Option<Result<FadeParts, FadeSkipReason>>,
    ) -> Option<Result<Beginning, FadeSkipReason>> {
        let left = (self.fade.frames > 0).then(|| self.memory_to_fade(new, frame));
        match (left, parts.unwrap_or(Err(FadeSkipReason::Late))) {
            (Some(Ok(left)), parts) => Some(parts.map(|parts| Beginning { parts, left })),
            (left, parts) => {
                parts.into_iter().for_each(|parts| self.executor.drop_later(parts));
                left.and_then(Result::err).map(Err)
            }
        }
    }

    /// The memory of the plan that renders, if the change to another one in this frame can be faded.
    fn memory_to_fade(&self, new: &Plan, frame: Option<&Frame<'_>>) -> Result<Arc<Residency>, FadeSkipReason> {
        let old = &self.running.as_ref().ok_or(FadeSkipReason::NewBeginning)?.plan;
        let frame = frame.ok_or(FadeSkipReason::Awaited)?;
        let of_old = output_of(old)?;
        let of_new = output_of(new)?;
        if of_old.name != of_new.name || size_of(old, of_old) != size_of(new, of_new) {
            return Err(FadeSkipReason::Outputs);
        }
        let left = self.executor.residency().filter(|_| !frame.reset && !self.executor.is_fresh());
        // A host may load plans into the executor.
        let is_ours = self.executor.plan().is_some_and(|plan| Arc::ptr_eq(plan, old));
        let left = left.filter(|_| is_ours).ok_or(FadeSkipReason::NewBeginning)?;
        if !left.can_be_copied() {
            return Err(FadeSkipReason::DepthHistory);
        }
        view_to_draw(frame, &of_old.name)?;
        Ok(left.clone())
    }

    /// Begins a fade from the plan that has rendered until now, if it is to be faded; the new plan is in. Returns the
    /// old plan if it does not go on.
    pub(super) fn begin_fade(
        &mut self,
        beginning: Option<Result<Beginning, FadeSkipReason>>,
        running: ActivePlan,
    ) -> Option<ActivePlan> {
        self.fade.missed = None;
        match beginning? {
            Ok(Beginning { parts, left }) => match self.joined(parts, &running) {
                Ok((parts, images)) => {
                    let (left, number, frames) = (Some(left), 1, self.fade.frames);
                    self.fade.fading = Some(Fading { parts, running, left, images, number, frames });
                    return None;
                }
                Err(error) => self.fade.miss(refused(error)),
            },
            Err(why) => self.fade.miss(why),
        }
        Some(running)
    }

    /// The second executor takes the place of ours.
    fn joined(&self, mut parts: FadeParts, running: &ActivePlan) -> Result<(FadeParts, BindGroup), GpuError> {
        parts.double.adopt_state(&self.executor, &running.uniforms.bytes)?;
        let images = self.pictures(&parts, running)?;
        Ok((parts, images))
    }

    /// The bind group of the pictures of both plans.
    fn pictures(&self, FadeParts { double, mixer }: &FadeParts, running: &ActivePlan) -> Result<BindGroup, GpuError> {
        let name = &running.plan.outputs[0].name;
        let [before, after] = [double, &self.executor].map(|executor| executor.output(name));
        let pictures = before.zip(after).ok_or(GpuError::NoPlan)?;
        scoped(self.executor.device(), WHAT, || Ok(mixer.images(self.executor.device(), pictures)))
    }

    /// From the next frame on the new plan renders alone, if a fade goes on.
    pub(super) fn end_fade(&mut self, why: FadeSkipReason) {
        if let Some(fading) = self.fade.fading.take() {
            self.give_back(fading);
            self.fade.missed = Some(why);
        }
    }

    /// Drops the old plan and what belongs to the fade.
    fn give_back(&mut self, fading: Fading) {
        self.executor.drop_later(fading);
        self.executor.forget_own_pictures();
    }

    /// Records the plan that is loaded; or, while a fade goes on, the old and the new one and their mix. If the old one
    /// cannot go on, the fade ends.
    pub(super) fn record_plans(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        draws: &mut [HostDraw<'_>],
    ) -> Result<(), PostError> {
        let Some(mut fading) = self.fade.fading.take() else {
            return Ok(self.executor.encode_drawing(encoder, frame, draws)?);
        };
        let target = match self.record_old(&mut fading, encoder, frame) {
            Ok(target) => target,
            Err(why) => {
                self.give_back(fading);
                self.fade.missed = Some(why);
                return Ok(self.executor.encode_drawing(encoder, frame, draws)?);
            }
        };
        self.executor.encode_drawing(encoder, &Frame { outputs: &[], ..*frame }, draws)?;
        fading.parts.mixer.record(encoder, &fading.images, &target, [fading.number, fading.frames]);
        fading.number += 1;
        if fading.number > fading.frames {
            self.give_back(fading);
        } else {
            self.fade.fading = Some(fading);
        }
        Ok(())
    }

    /// Records the old plan. Returns where the mix goes, or why it does not go on.
    fn record_old<'f>(
        &mut self,
        fading: &mut Fading,
        encoder: &mut CommandEncoder,
        frame: &Frame<'f>,
    ) -> Result<Target<'f>, FadeSkipReason> {
        let output = output_of(&fading.running.plan)?;
        let (view, rectangle) = view_to_draw(frame, &output.name)?;
        let part = rectangle.unwrap_or(Rectangle::of_texture(view.texture()));
        if !part.lies_in(view.texture()) || part.size() != size_of(&fading.running.plan, output) {
            return Err(FadeSkipReason::NewImages);
        }
        let format = self.executor.format_of((output, view), frame).map_err(refused)?;
        self.go_on(fading, format, encoder, frame).map_err(refused)?;
        Ok(Target { view, rectangle })
    }

    fn go_on(
        &mut self,
        fading: &mut Fading,
        format: wgpu::TextureFormat,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<(), GpuError> {
        let device = self.executor.device();
        if fading.parts.mixer.format != format {
            fading.parts.mixer = watched(device, WHAT, || Ok(Mixer::new(device, format)))?;
            fading.images = self.pictures(&fading.parts, &fading.running)?;
        }
        let Fading { parts: FadeParts { double, .. }, running, left, .. } = fading;
        if running.graph == self.age.graph {
            // Where a value needs another plan, the old one keeps the value that it had.
            let _ = running.uniforms.update(&mut running.dynamic, self.plans.graph());
        }
        running.write(double)?;
        if let Some(left) = left.take() {
            double.copy_memory(&left, encoder);
            self.executor.drop_later(left);
        }
        double.encode(encoder, &Frame { outputs: &[], ..*frame })
    }
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
