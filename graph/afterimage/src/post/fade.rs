//! Cross-fades: after a change in the background the old plan renders on for some frames, in an executor of its own,
//! and each frame is a mix of both.

use std::sync::Arc;

use afterimage_gpu::internal::{Fork, Residency, has_host_draws, part_view, scoped, watched};
use afterimage_gpu::wgpu::{self, CommandEncoder, Device, RenderPipeline, TextureFormat, TextureUsages, TextureView};
use afterimage_gpu::{
    Executor, Frame, FrameKind, FullScreenPipeline, GpuError, HostDraw, LoadedPlan, Rectangle, color_pass_in,
};
use afterimage_graph::image::Size;
use afterimage_graph::node::Resource;
use afterimage_plan::{Plan, PlanOutput};

use super::active::ActivePlan;
use super::values::GraphValues;

/// The longest fade: the shader has 16 bits for its frames.
const MAX_FRAMES: u16 = u16::MAX - 1;
const MIX: &str = include_str!("fade.wgsl");
const LABEL: &str = "the mix of a fade";

/// The frame does not follow one of the old plan: the first one, a reset, another device.
pub(super) const NEW_BEGINNING: &str = "the frame does not follow one of the old plan";
pub(super) const NEW_IMAGES: &str = "the images of the host have changed";
pub(super) const AWAITED: &str = "the host has waited for the change";

/// The number of frames of a fade, and the present fade.
#[derive(Default)]
pub(super) struct Fade {
    /// 0 for changes at once.
    frames: u16,
    running: Option<RunningFade>,
    /// The reason why the last change was not faded, or not to its end.
    pub(super) skip_reason: Option<String>,
}

/// The executor that continues the old plan, and the pipeline of the mix: the parts of a fade that are made in the
/// background.
pub(super) type FadeParts = (Fork, Mixer);

/// An old plan that renders next to the new one.
struct RunningFade {
    old: ActivePlan,
    fork: Fork,
    mixer: Mixer,
    /// The number of the next frame, from 1, and the number of frames.
    number: u16,
    frames: u16,
}

/// The pipeline that mixes two images into views of a format.
pub(super) struct Mixer {
    format: TextureFormat,
    pipeline: RenderPipeline,
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

    /// `true` if a frame of the old plan was dropped on which later ones rely.
    pub(super) fn has_lost_frames(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.fork.has_lost_frames())
    }

    /// The old plan.
    pub(super) fn old(&self) -> Option<&ActivePlan> {
        self.running.as_ref().map(|running| &running.old)
    }

    /// Updates the old plan to the present values of its graph. Where one needs another plan, it keeps its own.
    pub(super) fn update_old(&mut self, values: GraphValues<'_>) {
        if let Some(running) = &mut self.running {
            let _ = running.old.update(values);
        }
    }

    /// Notes why a change is not faded, if changes are.
    pub(super) fn skip(&mut self, why: &str) {
        self.skip_reason = (self.frames > 0).then(|| why.to_owned());
    }

    /// Ends the present fade: the new plan renders alone from the next frame on.
    pub(super) fn end(&mut self, executor: &mut Executor, why: &str) {
        if self.release(executor) {
            self.skip_reason = Some(why.to_owned());
        }
    }

    /// Drops the old plan and the resources of a fade, if there is one.
    fn release(&mut self, executor: &mut Executor) -> bool {
        let Some(running) = self.running.take() else { return false };
        executor.compiler.drop_later(running);
        executor.loaded_mut().into_iter().for_each(LoadedPlan::drop_bind_groups_of_own_outputs);
        true
    }

    /// Makes the parts of a fade from the active plan, on any thread; `None` if changes are not faded.
    pub(super) fn preparation(
        &self,
        executor: &Executor,
        active: &ActivePlan,
    ) -> Option<impl FnOnce() -> Result<FadeParts, GpuError> + Send + use<>> {
        let output = output_of(&active.plan).ok().filter(|_| self.frames > 0)?;
        let format = executor.host.last_format(&active.plan, output);
        let (fork, plan, uniforms) = (Fork::prepare(executor), active.plan.clone(), active.uniforms.clone());
        let device = executor.compiler.device.clone();
        Some(move || Ok((fork(plan, uniforms)?, Mixer::new(&device, format)?)))
    }

    /// Starts a fade from the old plan, after the new one is installed, or notes why the change is not faded and
    /// returns the old plan. `memory` is that of the old plan if the executor has rendered it.
    pub(super) fn start(
        &mut self,
        executor: &Executor,
        (old, memory): (ActivePlan, Option<Arc<Residency>>),
        new: &Plan,
        frame: Option<&Frame<'_>>,
        parts: Option<Result<FadeParts, GpuError>>,
    ) -> Option<ActivePlan> {
        self.skip_reason = None;
        let begun = check(&old.plan, new, frame).map_err(str::to_owned).and_then(|()| {
            let memory = memory.ok_or(NEW_BEGINNING)?;
            if !memory.can_be_copied() {
                return Err("an image of earlier frames is a depth or multisampled".to_owned());
            }
            let parts = parts.ok_or("the fade was set after the plan was begun")?;
            Ok((memory, parts.map_err(|error| error.to_string())?))
        });
        match begun {
            Ok((memory, (mut fork, mixer))) if self.frames > 0 => {
                fork.continue_from(executor, memory, &old.uniforms);
                self.running = Some(RunningFade { old, fork, mixer, number: 1, frames: self.frames });
                return None;
            }
            Ok((_, parts)) => executor.compiler.drop_later(parts),
            Err(why) => self.skip(&why),
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
        if let Some(running) = &mut self.running
            && let Err(why) = running.record_old(executor, encoder, frame)
        {
            self.end(executor, &why);
        }
        let Some(running) = &mut self.running else { return executor.encode_drawing(encoder, frame, draws) };
        executor.encode_drawing(encoder, &Frame { outputs: &[], ..*frame }, draws)?;
        running.mix(executor, encoder, frame)?;
        running.number += 1;
        if running.number > running.frames {
            self.release(executor);
        }
        Ok(())
    }
}

impl RunningFade {
    /// Records the old plan, or returns why the fade ends.
    fn record_old(
        &mut self,
        executor: &mut Executor,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<(), String> {
        let output = output_of(&self.old.plan)?;
        let view = view_to_draw(frame, &output.name)?;
        let size = frame.size_of(&output.name, view);
        let part = frame.rectangle(&output.name).unwrap_or(Rectangle::whole(size));
        if !part.lies_in(size) || part.size() != size_of(&self.old.plan, output) {
            return Err(NEW_IMAGES.to_owned());
        }
        let refused = |error: GpuError| error.to_string();
        let device = &executor.compiler.device;
        let format = executor.host.format_of(device, output, view, frame).map_err(refused)?;
        if self.mixer.format != format {
            self.mixer = Mixer::new(device, format).map_err(refused)?;
        }
        self.old.write(&mut self.fork.executor);
        self.fork.encode(encoder, &Frame { outputs: &[], ..*frame }).map_err(refused)
    }

    /// Records the mix of both outputs into the host's view.
    fn mix(&self, executor: &Executor, encoder: &mut CommandEncoder, frame: &Frame<'_>) -> Result<(), GpuError> {
        let Self { fork, mixer, number, frames, .. } = self;
        let [(name, view)] = frame.outputs else { return Err(GpuError::NoPlan) };
        let [old, new] = [&fork.executor, executor].map(|executor| executor.output(name).ok_or(GpuError::NoPlan));
        let (old, new, device) = (old?, new?, &executor.compiler.device);
        let images = scoped(device, LABEL, || {
            let [old, new] = [old, new].map(|texture| part_view(texture, 0, 0));
            let entry =
                |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
            Ok::<_, GpuError>(device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(LABEL),
                layout: &mixer.pipeline.get_bind_group_layout(0),
                entries: &[entry(0, &old), entry(1, &new)],
            }))
        })?;
        let rectangle = frame.rectangle(name);
        let mut pass = color_pass_in(encoder, Some("afterimage fade"), view, rectangle);
        if let Some(Rectangle { x, y, width, height }) = rectangle {
            pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        }
        pass.set_pipeline(&mixer.pipeline);
        pass.set_bind_group(0, &images, &[]);
        let share = u32::from(*number) << 16 | (u32::from(*frames) + 1);
        pass.draw(0..3, share..share + 1);
        Ok(())
    }
}

impl Mixer {
    fn new(device: &Device, format: TextureFormat) -> Result<Self, GpuError> {
        watched(device, LABEL, || {
            let source = wgpu::ShaderSource::Wgsl(MIX.into());
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(LABEL), source });
            let pipeline = FullScreenPipeline {
                label: "fade",
                module: &module,
                vertex: "corner",
                fragment: "mixed",
                layout: None,
                format,
                samples: 1,
                cache: None,
            };
            Ok(Self { format, pipeline: pipeline.create(device) })
        })
    }
}

/// Checks that the change from one plan to another one in this frame can be faded.
fn check(old: &Plan, new: &Plan, frame: Option<&Frame<'_>>) -> Result<(), &'static str> {
    let frame = frame.ok_or(AWAITED)?;
    let (old_output, new_output) = (output_of(old)?, output_of(new)?);
    if old_output.name != new_output.name || size_of(old, old_output) != size_of(new, new_output) {
        return Err(OUTPUTS);
    }
    if frame.kind == FrameKind::Cut {
        return Err(NEW_BEGINNING);
    }
    view_to_draw(frame, &old_output.name).map(drop)
}

const OUTPUTS: &str = "the plans do not have one output each, of the same name and size";

/// The output of a plan that can be faded.
fn output_of(plan: &Plan) -> Result<&PlanOutput, &'static str> {
    let [output] = plan.outputs.as_slice() else { return Err(OUTPUTS) };
    if has_host_draws(plan) {
        return Err("the host draws into images of the pipeline");
    }
    // In the host's image it may have another precision than in ours.
    if plan.work().any(|pass| pass.reads().contains(&Resource::Image(output.image))) {
        return Err("a pass reads the output");
    }
    Ok(output)
}

fn size_of(plan: &Plan, output: &PlanOutput) -> Size {
    plan.image(output.image).desc.size
}

/// The host's only view, for this output, if it can be drawn to.
fn view_to_draw<'f>(frame: &Frame<'f>, name: &str) -> Result<&'f TextureView, &'static str> {
    match frame.outputs {
        [(known, view)] if *known == name && view.texture().usage().contains(TextureUsages::RENDER_ATTACHMENT) => {
            Ok(view)
        }
        _ => Err("the host gives no view of the output with the usage `RENDER_ATTACHMENT`"),
    }
}
