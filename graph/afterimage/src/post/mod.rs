//! A pipeline on the device of a host: plans follow the images, the facts and the parameters.

mod active;
mod announced;
mod bindings;
mod buffer_copies;
mod fade;
mod govern;
mod governed;
mod handles;
mod names;
mod opened;
mod parameters;
mod pass_times;
mod plans;
mod readings;
mod tiers;
mod values;
mod watches;

use std::sync::Arc;

use afterimage_gpu::internal::watched;
use afterimage_gpu::wgpu::{self, CommandEncoder};
use afterimage_gpu::{DrawTargets, Executor, Frame, FrameKind, Gpu, GpuError, HostDraw, TaskPool, span};
use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_plan::{HostInputs, NeedsPlan, Options, Plan, PlanError};

use active::ActivePlan;
pub use announced::ExpectedFrame;
use announced::{AnnouncedFrame, MAX_FRAMES};
use bindings::HostBindings;
pub use bindings::HostImage;
pub use buffer_copies::Reading;
use fade::Fade;
use governed::Governed;
use names::NameCheck;
use opened::Opened;
pub use pass_times::PassTimes;
use plans::{Job, NextPlan, Plans};
use readings::Readings;
pub use readings::Watch;
use values::Values;
pub use values::{Control, Parameter, ParameterInfo};

use crate::error::PostError;

/// Frames between two checks whether the device is lost.
const FRAMES_BETWEEN_CHECKS: u64 = 32;

/// A pipeline on the host's device: parameters, facts, tiers, and the commands of a frame.
///
/// [`open`](Self::open) reads a file, and [`new`](Self::new) takes a graph that the host has checked, which has no
/// tiers and no files.
///
/// A plan is made at once for the first frame, and when the host's images change their sizes or formats, because no
/// frame can use another one. For all other changes, such as a tier, a file or a fact, the next plan is made and
/// compiled in the background while the active one renders, and a later frame activates it. Memory that is equal in
/// both plans is kept, also histories; handles of parameters and the values that the host has set stay valid.
/// [`set_fade`](Self::set_fade) fades from one to the other.
pub struct Post {
    executor: Executor,
    /// The files; `None` if the host has given a graph.
    opened: Option<Opened>,
    values: Values,
    plans: Plans,
    bindings: HostBindings,
    fade: Fade,
    readings: Readings,
    names: NameCheck,
    governed: Option<Governed>,
    /// Frames that have been recorded.
    frame: u64,
}

impl Post {
    /// A graph on the host's device. Its plans rely on [`caps`](afterimage_gpu::caps).
    pub fn new(gpu: &Gpu, graph: Graph) -> Self {
        Self::with_executor(gpu.host_executor(), graph)
    }

    /// The same with an executor that the host has made.
    pub fn with_executor(executor: Executor, graph: Graph) -> Self {
        Self {
            executor,
            opened: None,
            values: Values::new(graph),
            plans: Plans::new(),
            bindings: HostBindings::default(),
            fade: Fade::default(),
            readings: Readings::default(),
            names: NameCheck::default(),
            governed: None,
            frame: 0,
        }
    }

    /// The same pipeline for another view: a second camera, window or half of the screen, with images and histories of
    /// its own. Both share compiled pipelines and cached plans; parameters and facts are copied, and a
    /// [budget](Self::govern) is not. Handles are valid for both. Each reads files for itself.
    pub fn clone_for_view(&self) -> Self {
        Self {
            executor: self.executor.clone_for_view(),
            opened: self.opened_for_view(),
            values: self.values.for_view(),
            plans: self.plans.without_plans(),
            bindings: self.bindings.clone(),
            fade: self.fade.for_view(),
            readings: self.readings.for_view(),
            names: NameCheck::default(),
            governed: None,
            frame: 0,
        }
    }

    /// The executor, for timing, resets and read-back.
    pub fn executor(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// The graph at the present values of its parameters.
    pub fn graph(&self) -> &Graph {
        self.values.graph()
    }

    /// The plan that renders.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.plans.active.as_ref().map(|active| &active.plan)
    }

    /// The attachments of a pass that the host fills, by the name of its node: what its pipelines are made for. `None`
    /// before a plan is loaded, and if the plan has no such pass.
    pub fn draw_targets(&self, node: &str) -> Option<DrawTargets> {
        self.executor.loaded()?.draw_targets(node)
    }

    /// `true` while a plan is being made, and if one will be at the next frame.
    pub fn is_changing(&self) -> bool {
        self.plans.is_changing()
    }

    /// Sets a fact that `when` conditions test.
    pub fn set_fact(&mut self, name: impl Into<String>, fact: impl Into<Fact>) {
        let (name, fact) = (name.into(), fact.into());
        if !self.plans.facts.get(&name).is_some_and(|known| is_like(known, fact)) {
            self.names.queue();
        }
        self.plans.facts.set(name, fact);
        self.plans.queue();
    }

    /// The facts that the host has set.
    pub fn facts(&self) -> &Facts {
        &self.plans.facts
    }

    /// Replaces all facts.
    pub fn set_facts(&mut self, facts: Facts) {
        let is_known =
            |(name, fact): (&str, Fact)| self.plans.facts.get(name).is_some_and(|known| is_like(known, fact));
        if facts.iter().count() != self.plans.facts.iter().count() || !facts.iter().all(is_known) {
            self.names.queue();
        }
        if self.plans.facts != facts {
            self.plans.facts = facts;
            self.plans.queue();
        }
    }

    /// Names that the host uses and the pipeline does not know, each in a sentence with the nearest one that it knows:
    /// of inputs, outputs, facts, watched values and drawn nodes. They are looked at in the first frame of each plan,
    /// and after a new fact or watch, and are logged once.
    pub fn warnings(&self) -> &[String] {
        &self.names.warnings
    }

    /// Sets the options of plans.
    pub fn set_options(&mut self, options: Options) {
        self.plans.options = options;
        self.plans.queue();
    }

    /// States the size in which the pipeline works, whatever the sizes of the [rectangles](Frame::rectangles) of its
    /// inputs: colors are filtered to it, and data takes the nearest texel. So a scene may be rendered at another size
    /// in every frame without another plan. With `None` the size is that of the first input's rectangle, and another
    /// size is another plan. Inputs without a rectangle keep their sizes.
    pub fn set_size(&mut self, size: Option<Size>) {
        self.bindings.size = size;
        self.plans.note_change();
    }

    /// States that all texels of an input are finite, within ±65504, and negative only where its color state allows
    /// it, so that plans need not sanitize them.
    pub fn assume_finite(&mut self, input: impl Into<String>) {
        self.bindings.finite.insert(input.into());
        self.names.queue();
        self.plans.queue();
    }

    /// States that the image of an output holds linear light, as the main texture of an engine does which is encoded
    /// later: what the pipeline has encoded as sRGB or with a gamma is decoded again, at the end of its last pass. For
    /// an image of an sRGB format this is so anyway.
    pub fn set_output_linear(&mut self, output: impl Into<String>) {
        self.bindings.linear.insert(output.into());
        self.names.queue();
        self.plans.note_change();
    }

    /// Creates and compiles plans in the host's task pool from now on, and not on the threads of the crate. See
    /// [`TaskPool`].
    pub fn set_task_pool(&mut self, pool: TaskPool) {
        self.executor.compiler.pool = Some(pool);
    }

    /// Replaces the graph by one that the host has checked, until the next tier or reload. Values that the host has
    /// set hold in the new graph where it has their parameters and accepts them; handles stay valid. A graph that
    /// differs in values of parameters with handles alone needs no plan where these need none.
    pub fn change(&mut self, graph: Graph) {
        if self.values.replace(graph) {
            self.plans.queue();
        }
        self.drop_unused_graphs();
        self.names.queue();
    }

    /// Labels each pass with its nodes in the commands, for tools such as RenderDoc. It costs a little time to record.
    pub fn label_passes(&mut self, on: bool) {
        self.executor.label_passes(on);
    }

    /// Continues on another device, after the first was lost, with all values, facts, options and handles. Histories
    /// start again, and the next frame waits for its plan.
    pub fn rebuild(&mut self, gpu: &Gpu) {
        let pool = self.executor.compiler.pool.clone();
        self.fade.end(&mut self.executor, fade::NEW_BEGINNING);
        self.executor = gpu.host_executor();
        self.executor.compiler.pool = pool;
        self.plans = self.plans.without_plans();
        self.readings.reset();
    }

    /// Checks that the device is not lost, at the cost of a buffer of a few bytes.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`].
    pub fn check_device(&self) -> Result<(), GpuError> {
        watched(&self.executor.compiler.device, "a check of the device", || Ok(()))
    }

    /// Records a frame into the host's encoder. Frames are submitted in the order in which they are recorded, each
    /// once; several may be recorded before the first is submitted, also into one encoder. After one that is not
    /// submitted, the next is a [cut](FrameKind::Cut); what the dropped one has begun, such as a plan or a value, the
    /// next begins again.
    ///
    /// wgpu drops the commands of a lost device without an error, so every 32nd frame checks the device: see
    /// [`check_device`](Self::check_device). [`wgpu::Device::set_device_lost_callback`] reports it at once.
    ///
    /// # Errors
    /// Without a recorded frame: the graph cannot be planned for these images, or the device reports an error. With a
    /// recorded frame of the old plan: a plan that was being made has failed. Each failure is reported once.
    pub fn encode(&mut self, encoder: &mut CommandEncoder, frame: &Frame<'_>) -> Result<(), PostError> {
        self.encode_drawing(encoder, frame, &mut [])
    }

    /// The same with the draws of passes that the host fills, by the names of their nodes: those of the kinds of
    /// `afterimage_nodes::HOST`, and of kinds that use `Recorder::host_draw`. What the plan does not need is ignored.
    ///
    /// A pass has its attachments, which the plan makes; the host sets pipelines and bindings. [`draw_targets`] states
    /// their formats. Images that the host draws are sanitized where they are read.
    ///
    /// [`draw_targets`]: Self::draw_targets
    ///
    /// # Errors
    /// As [`encode`](Self::encode), and [`GpuError::MissingDraw`].
    pub fn encode_drawing(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        draws: &mut [HostDraw<'_>],
    ) -> Result<(), PostError> {
        span!("afterimage::frame");
        if self.frame.is_multiple_of(FRAMES_BETWEEN_CHECKS) {
            self.check_device()?;
        }
        let levels = self.executor.host.levels(&self.executor.compiler.device, frame)?;
        let with_levels = Frame { levels: &levels, ..*frame };
        let updated = self.update_plan(&with_levels);
        self.names.update(&self.values, &self.plans, &self.bindings, &self.readings, frame, draws);
        let failure = updated?;
        self.record(encoder, &with_levels, draws)?;
        self.follow_governor(frame.dt)?;
        match failure {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Chooses the plan of a frame: the active one, the next one if it is created, or, for other images of the host,
    /// one that is made at once. Starts to create the next one if something has changed. Returns why one has failed
    /// that was made in the background.
    ///
    /// # Errors
    /// There is no plan for the frame.
    fn update_plan(&mut self, frame: &Frame<'_>) -> Result<Option<PostError>, PostError> {
        let fits = match &self.plans.active {
            Some(active) => self.bindings.fit(self.values.graph(), &active.inputs, frame)?,
            None => false,
        };
        if !fits {
            let inputs = self.bindings.inputs(self.values.graph(), frame)?;
            self.fade.end(&mut self.executor, fade::NEW_IMAGES);
            self.load_for(inputs)?;
            return Ok(None);
        }
        self.executor.recover();
        if frame.kind == FrameKind::Cut || self.executor.frames.is_fresh || self.fade.has_lost_frames() {
            self.fade.end(&mut self.executor, fade::NEW_BEGINNING);
        }
        let mut failure = None;
        // A plan waits for the end of a fade.
        if !self.fade.is_running()
            && let Some(job) = self.plans.take_finished()
        {
            failure = self.activate(job, Some(frame)).err();
        }
        self.plans.start_next(&self.executor, &mut self.values, &self.fade);
        Ok(failure.or_else(|| self.prepare_ahead().err()))
    }

    /// Records a frame of the plan that is loaded.
    ///
    /// # Errors
    /// The device reports an error.
    pub(crate) fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        draws: &mut [HostDraw<'_>],
    ) -> Result<(), GpuError> {
        self.update_uniforms();
        let old = self.fade.old().map(ActivePlan::revision);
        if let Some(values) = old.and_then(|revision| self.values.of_revision(revision)) {
            self.fade.update_old(values);
        }
        self.fade.record(&mut self.executor, encoder, frame, draws)?;
        self.frame += 1;
        let plan = self.plans.active.as_ref().map(|active| &active.plan);
        self.readings.record(&self.executor, plan, self.frame, encoder)
    }

    /// Updates the uniforms of the active plan. If a value needs another plan, that is queued.
    fn update_uniforms(&mut self) {
        let Some(active) = &mut self.plans.active else { return };
        let revision = active.revision();
        let updated = self.values.of_revision(revision).map_or(Ok(()), |values| active.update(values));
        active.write(&mut self.executor);
        // The next plan of a graph that has been replaced is on its way.
        if updated == Err(NeedsPlan) && revision == self.values.revision.graph {
            self.values.drop_plans();
            self.plans.queue();
        }
        self.drop_unused_graphs();
    }

    /// Drops graphs that have been replaced and of which no plan renders any more.
    fn drop_unused_graphs(&mut self) {
        let rendering = [self.plans.active.as_ref(), self.fade.old()].map(|plan| plan.map(ActivePlan::revision));
        let unused = self.values.take_unused(|revision| rendering.contains(&Some(revision)));
        if !unused.is_empty() {
            self.executor.compiler.drop_later(unused);
        }
    }

    /// Makes the plan for the host's inputs and loads it, if it is not the active one.
    ///
    /// # Errors
    /// The graph cannot be planned for them, or the device refuses the plan.
    pub(crate) fn load_for(&mut self, inputs: HostInputs) -> Result<&Arc<Plan>, PostError> {
        // A plan for these images that is being made need not be made twice. Its error counts only where the plan that
        // is made now has it, too: the graph may have changed since.
        let _ = self.plans.take_ahead(&self.executor, &mut self.values, Some(&inputs));
        self.plans.cancel_next();
        let planned = self.plans.plan(&self.executor, &mut self.values, inputs.clone())?;
        if self.plan().is_none_or(|plan| !Arc::ptr_eq(plan, &planned.plan)) {
            let active = ActivePlan::new(inputs, &planned, self.values.present());
            self.executor.load_with(active.plan.clone(), active.uniforms.clone())?;
            if self.plans.active.replace(active).is_some() {
                self.fade.skip(fade::NEW_IMAGES);
            }
        }
        self.plans.forget_next();
        self.names.queue();
        Ok(self.plan().expect("it is loaded"))
    }

    /// The plan for these inputs of the host, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned for them.
    pub fn plan_for(&mut self, inputs: HostInputs) -> Result<Arc<Plan>, PlanError> {
        Ok(self.plans.plan(&self.executor, &mut self.values, inputs)?.plan.clone())
    }

    /// The plan for these inputs of the host, whatever the device has for images: to be made in bands.
    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(crate) fn plan_in_bands(&self, inputs: HostInputs) -> Result<Plan, PlanError> {
        self.plans.plan_with(&self.executor, &self.values, inputs, |caps, options| {
            (caps.max_side, caps.max_memory, options.alias) = (u32::MAX, u64::MAX, afterimage_plan::Alias::None);
        })
    }

    /// Installs a plan that a worker has made. `frame` is its first frame, or `None` if the host waits for the plan.
    fn activate(&mut self, job: Job<NextPlan>, frame: Option<&Frame<'_>>) -> Result<(), PostError> {
        if job.revision.graph != self.values.revision.graph {
            // A plan for the present graph follows.
            self.executor.compiler.drop_later(job.worker);
            return Ok(());
        }
        let NextPlan { active, prepared, new, fade } = job.worker.join()??;
        // A host may have loaded another plan into the executor.
        let is_loaded = self.executor.plan().is_some_and(|plan| self.plan().is_some_and(|own| Arc::ptr_eq(plan, own)));
        let memory = self.executor.loaded().filter(|_| is_loaded && !self.executor.frames.is_fresh);
        let memory = memory.map(|loaded| loaded.residency().clone());
        self.names.queue();
        let old_memory = self.executor.install(prepared)?;
        new.keep(&self.executor, &mut self.values, job.revision);
        let plan = active.plan.clone();
        let old = self.plans.active.replace(active);
        let old = old.and_then(|old| self.fade.start(&self.executor, (old, memory), &plan, frame, fade));
        self.executor.compiler.drop_later((old_memory, old));
        Ok(())
    }

    /// Waits for the plan that the present facts and values need, and activates it. A [fade](Self::set_fade) ends.
    ///
    /// # Errors
    /// It cannot be made, or the device refuses it: the old plan renders on.
    pub fn finish_changes(&mut self) -> Result<(), PostError> {
        self.fade.end(&mut self.executor, fade::AWAITED);
        while self.is_changing() && self.plans.active.is_some() {
            if let Some(job) = self.plans.take_next() {
                self.activate(job, None)?;
            }
            self.plans.start_next(&self.executor, &mut self.values, &self.fade);
        }
        Ok(())
    }

    /// Makes and compiles the plans of frames like these in the background, also before the first frame, and again
    /// after each change of facts, tiers and pipelines. A frame that is like one of them then needs memory for its
    /// images only. They replace those of the call before; none are forgotten by an empty list.
    ///
    /// ```no_run
    /// # use afterimage::{Post, host::{ExpectedFrame, HostImage, PostError}, wgpu::TextureFormat};
    /// # fn run(post: &mut Post, draw_loading_screen: impl Fn()) -> Result<(), PostError> {
    /// let scene = HostImage::new(1920, 1080, TextureFormat::Rgba16Float);
    /// let screen = HostImage::new(1920, 1080, TextureFormat::Bgra8Unorm);
    /// let frame = ExpectedFrame {
    ///     inputs: &[("scene", scene)],
    ///     outputs: &[("display", screen)],
    ///     ..ExpectedFrame::default()
    /// };
    /// post.prepare(&[frame])?;
    /// while !post.is_prepared()? {
    ///     draw_loading_screen();
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// There are more than 16 frames, or an image is missing or does not fit the pipeline. Nothing changes.
    pub fn prepare(&mut self, frames: &[ExpectedFrame<'_>]) -> Result<(), PostError> {
        if frames.len() > MAX_FRAMES {
            return Err(PostError::TooManyFrames { given: frames.len(), most: MAX_FRAMES });
        }
        let frames: Vec<AnnouncedFrame> = frames.iter().map(AnnouncedFrame::from).collect();
        for frame in &frames {
            self.bindings.inputs(self.values.graph(), frame)?;
        }
        self.plans.announce(frames);
        self.prepare_ahead()
    }

    /// `true` once the plans of all frames of [`prepare`](Self::prepare) are made and compiled. Each call, and each
    /// frame, takes a plan that is finished and starts the next.
    ///
    /// # Errors
    /// A plan cannot be made: once for each.
    pub fn is_prepared(&mut self) -> Result<bool, PostError> {
        self.prepare_ahead()?;
        Ok(self.plans.are_prepared())
    }

    fn prepare_ahead(&mut self) -> Result<(), PostError> {
        self.plans.take_ahead(&self.executor, &mut self.values, None)?;
        self.plans.start_ahead(&self.executor, &mut self.values, &self.bindings);
        Ok(())
    }

    /// Fades from the old plan to the new one over this many frames after each change that is made in the background,
    /// at most 65,534; 0, the default, changes at once. Both plans render in these frames, each with histories and
    /// adaptation of its own, and frame `k` of `n` has `k / (n + 1)` of the new output: of its encoded values where the
    /// host's image holds those, of its linear values where it holds those. The frame before them is of the old plan
    /// alone, and the frame after them of the new plan alone, bit for bit what it would be without a fade.
    ///
    /// In these frames the old plan has memory of its own next to that of the new one, which is allocated in the
    /// background with the new plan, and a second executor; the next frame has neither. Values of parameters change
    /// both outputs. A change that is ready waits for the end of a fade. A reset, another size or other images of the
    /// host, [`finish_changes`](Self::finish_changes) and [`rebuild`](Self::rebuild) end a fade at once.
    /// [`fade_skip_reason`](Self::fade_skip_reason) states why a change was not faded.
    ///
    /// The number holds for the next changes, here and in views that [`clone_for_view`](Self::clone_for_view) makes
    /// from now on.
    pub fn set_fade(&mut self, frames: u16) {
        self.fade.set_frames(frames);
    }

    /// `true` if the next frame is a mix of two plans, unless something ends the fade.
    pub fn is_fading(&self) -> bool {
        self.fade.is_running()
    }

    /// The reason why the last change was not faded, or not to its end, as a sentence. `None` if it was, if there was
    /// none, and without [`set_fade`](Self::set_fade).
    pub fn fade_skip_reason(&self) -> Option<&str> {
        self.fade.skip_reason.as_deref()
    }

    /// The number of the last frame that shaders saw, from which noise is made.
    pub fn noise_number(&self) -> u32 {
        self.executor.frames.last_number()
    }

    /// The number of frames that have been recorded: that of the last one, counted from 1.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// The texture of an image of the plan that renders, by its label, `node.port`, or by its name in
    /// [`Plan::image_names`]. It holds the texels of the last frame where the plan shares no memory:
    /// [`Alias::None`](afterimage_plan::Alias::None). `None` for images of the host, and for those that no pass uses.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        self.executor.loaded()?.image(name)
    }

    /// The texture of an output of the last frame, unless the host gave one.
    ///
    /// # Errors
    /// [`GpuError::NoPlan`] before a first frame; the loaded plan has no such output.
    pub fn output(&self, name: &str) -> Result<&wgpu::Texture, GpuError> {
        let plan = self.plan().ok_or(GpuError::NoPlan)?;
        self.executor.output(name).ok_or_else(|| GpuError::unknown_output(plan, name))
    }

    /// The buffer of a table or value of the loaded plan, by its label.
    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(crate) fn buffer(&self, label: &str) -> Option<&wgpu::Buffer> {
        self.executor.loaded()?.buffer(label)
    }
}

fn is_like(known: Fact, fact: Fact) -> bool {
    let is_usual = !matches!(fact, Fact::Number(number) if number.is_nan());
    is_usual && std::mem::discriminant(&known) == std::mem::discriminant(&fact)
}

// Hosts encode on any thread, and look from several.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Post>();
};
