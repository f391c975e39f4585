//! A pipeline on a device that may belong to somebody else: plans follow the images, the facts and the parameters.

mod active;
mod bindings;
mod buffer_copies;
mod controls;
mod error;
mod fade;
mod govern;
mod governed;
mod host_graph;
mod live_graph;
mod names;
mod pass_times;
mod plan_state;
mod prepared;
mod readings;

use std::sync::Arc;

use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::value::{ParamType, Value};
use afterimage_plan::{Alias, Caps, HostInputs, NeedsPlan, Options, Plan, PlanError, PlanRequest, plan};
use wgpu::{CommandEncoder, Device, Queue};

use crate::device::caps;
use crate::error::GpuError;
use crate::executor::{DrawTargets, Executor, Frame, FrameKind, HostDraw};
use crate::platform::{TaskPool, Worker, watched};
use active::ActivePlan;
use bindings::HostBindings;
pub use bindings::HostImage;
pub use buffer_copies::Reading;
pub use controls::{Control, Parameter, ParameterInfo};
pub use error::PostError;
use fade::Fade;
pub use fade::FadeSkipReason;
use governed::Governed;
pub use governed::TierGraph;
use host_graph::HostGraph;
use live_graph::GraphValues;
use names::NameCheck;
pub use pass_times::PassTimes;
use plan_state::{CreatedPlan, Creation, PlanState};
pub use prepared::ExpectedFrame;
use prepared::{KeptFrame, MAX_FRAMES, PlansAhead};
use readings::Readings;
pub use readings::Watch;

/// Frames between two checks whether the device is lost.
const FRAMES_BETWEEN_CHECKS: u64 = 32;

/// A pipeline on the host's device: a graph, its plans and an executor.
///
/// ```no_run
/// # use afterimage_gpu::{Frame, Post, wgpu};
/// # use afterimage_graph::{check::{CheckOptions, check}, document::parse, node::Registry};
/// # fn run(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder,
/// #     scene: &wgpu::TextureView, screen: &wgpu::TextureView, text: &str) -> Result<(), Box<dyn std::error::Error>> {
/// let kinds = Registry::new(&[afterimage_nodes::ALL])?;
/// let (graph, _warnings) = check(&parse("look.ron", text)?, &kinds, &CheckOptions::default())?;
/// let mut post = Post::new(adapter, device, queue, graph);
/// let strength = post.parameter::<f32>("lit.strength")?;
/// // In every frame:
/// post.set(strength, 0.3)?;
/// let (inputs, outputs) = (&[("scene", scene)], &[("display", screen)]);
/// post.encode(encoder, &Frame { inputs, outputs, dt: 1.0 / 60.0, ..Frame::default() })?;
/// # Ok(())
/// # }
/// ```
///
/// A plan is made at once for the first frame, and when the host's images change their sizes or formats, because no
/// frame can use another one. For all other changes the next plan is made and compiled in the background while the
/// active one renders, and a later frame activates it. Memory that is equal in both plans is kept, also histories.
/// [`set_fade`](Self::set_fade) fades from one to the other.
pub struct Post {
    executor: Executor,
    /// The graph, and the life of its next plan.
    graph: HostGraph,
    bindings: HostBindings,
    /// The plan that renders.
    active: Option<ActivePlan>,
    ahead: PlansAhead,
    fade: Fade,
    readings: Readings,
    names: NameCheck,
    governed: Option<Governed>,
    /// Frames that have been recorded.
    frame: u64,
}

impl Post {
    /// A pipeline on the host's device. Its plans rely on [`caps`](crate::caps).
    pub fn new(adapter: &wgpu::Adapter, device: &Device, queue: &Queue, graph: Graph) -> Self {
        Self::with_executor(Executor::with_caps(device, queue, caps(adapter, device)), graph)
    }

    /// The same with an executor that the host has made.
    pub fn with_executor(executor: Executor, graph: Graph) -> Self {
        Self {
            executor,
            graph: HostGraph::new(graph),
            bindings: HostBindings::default(),
            active: None,
            ahead: PlansAhead::default(),
            fade: Fade::default(),
            readings: Readings::default(),
            names: NameCheck::default(),
            governed: None,
            frame: 0,
        }
    }

    /// The same pipeline for another view: a second camera, window or half of the screen, with images and histories of
    /// its own. Both share compiled pipelines and cached plans; parameters and facts are copied, and a
    /// [budget](Self::govern) is not. Handles are valid for both.
    pub fn clone_for_view(&self) -> Self {
        Self {
            executor: self.executor.clone_for_view(),
            graph: self.graph.for_view(),
            bindings: self.bindings.clone(),
            active: None,
            ahead: self.ahead.without_plans(),
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
        self.graph.graph()
    }

    /// The plan that renders.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.active.as_ref().map(|active| &active.plan)
    }

    /// The attachments of a pass that the host fills, by the name of its node: what its pipelines are made for. `None`
    /// before a plan is loaded, and if the plan has no such pass.
    pub fn draw_targets(&self, node: &str) -> Option<DrawTargets> {
        self.executor.draw_targets(node)
    }

    /// Whether a plan is being made, or will be at the next frame.
    pub fn is_changing(&self) -> bool {
        !matches!(self.graph.next_plan, PlanState::Ok)
    }

    /// Sets a fact that `when` conditions test.
    pub fn set_fact(&mut self, name: impl Into<String>, fact: impl Into<Fact>) {
        let (name, fact) = (name.into(), fact.into());
        if !self.graph.facts().get(&name).is_some_and(|known| is_like(known, fact)) {
            self.names.queue();
        }
        self.graph.set_fact(name, fact);
    }

    /// The facts that the host has set.
    pub fn facts(&self) -> &Facts {
        self.graph.facts()
    }

    /// Replaces all facts.
    pub fn set_facts(&mut self, facts: Facts) {
        let is_known =
            |(name, fact): (&str, Fact)| self.graph.facts().get(name).is_some_and(|known| is_like(known, fact));
        if facts.iter().count() != self.graph.facts().iter().count() || !facts.iter().all(is_known) {
            self.names.queue();
        }
        self.graph.set_facts(facts);
    }

    /// Names that the host uses and the pipeline does not know, each in a sentence with the nearest one that it knows:
    /// of inputs, outputs, facts, watched values and drawn nodes. They are looked at in the first frame of each plan,
    /// and after a new fact or watch, and are logged once.
    pub fn warnings(&self) -> &[String] {
        &self.names.warnings
    }

    /// Sets the options of plans.
    pub fn set_options(&mut self, options: Options) {
        self.graph.set_options(options);
    }

    /// States the size in which the pipeline works, whatever the sizes of the [rectangles](Frame::rectangles) of its
    /// inputs: light is filtered to it, and data takes the nearest texel. So a scene may be rendered at another size in
    /// every frame without another plan. With `None` the size is that of the first input's rectangle, and another size
    /// is another plan. Inputs without a rectangle keep their sizes.
    pub fn set_size(&mut self, size: Option<Size>) {
        self.bindings.size = size;
        self.graph.note_change();
    }

    /// Invariants that all texels of an input are finite, within ±65504, and negative only where its color state allows
    /// it, so that plans need not sanitize them.
    pub fn assume_finite(&mut self, input: impl Into<String>) {
        self.bindings.finite.insert(input.into());
        self.names.queue();
        self.graph.queue_plan();
    }

    /// States that the image of an output holds linear light, as the main texture of an engine does which is encoded
    /// later: what the pipeline has encoded as sRGB or with a gamma is decoded again, at the end of its last pass. For
    /// an image of an sRGB format this is so anyway.
    pub fn set_output_linear(&mut self, output: impl Into<String>) {
        self.bindings.linear.insert(output.into());
        self.names.queue();
        self.graph.note_change();
    }

    /// Creates and compiles plans in the host's task pool from now on, and not on the threads of the crate. See
    /// [`TaskPool`].
    pub fn set_task_pool(&mut self, pool: TaskPool) {
        self.executor.set_task_pool(pool);
    }

    /// Replaces the graph: another tier, or another pipeline. Values that the host has set hold in the new graph where
    /// it has their parameters and accepts them; handles stay valid. A graph that differs in values of parameters with
    /// handles alone needs no plan where these need none.
    pub fn change(&mut self, graph: Graph) {
        self.graph.change(graph);
        self.drop_unused_graphs();
        self.names.queue();
    }

    /// Labels each pass with its nodes in the commands, for tools such as RenderDoc. It costs a little time to record.
    pub fn label_passes(&mut self, on: bool) {
        self.executor.label_passes(on);
    }

    /// Recreates all GPU resources on a new device. Parameters, facts and options stay, histories start again; the next
    /// frame makes its plan and waits for it.
    pub fn rebuild(&mut self, adapter: &wgpu::Adapter, device: &Device, queue: &Queue) {
        let pool = self.executor.task_pool().cloned();
        self.executor = Executor::with_caps(device, queue, caps(adapter, device));
        if let Some(pool) = pool {
            self.executor.set_task_pool(pool);
        }
        self.active = None;
        self.graph.next_plan = PlanState::Queued;
        self.fade.end(&mut self.executor, FadeSkipReason::NewBeginning);
        self.ahead = self.ahead.without_plans();
        self.readings.reset();
    }

    /// Checks that the device is not lost, at the cost of a buffer of a few bytes.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`].
    pub fn check_device(&self) -> Result<(), GpuError> {
        watched(self.executor.device(), "a check of the device", || Ok(()))
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
        let levels = self.executor.view_levels(frame)?;
        let with_levels = Frame { levels: &levels, ..*frame };
        let updated = self.update_plan(&with_levels);
        let plan = self.active.as_ref().map(|active| &*active.plan);
        self.names.update(&self.graph, &self.bindings, &self.readings, plan, frame, draws);
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
        let fits = match &self.active {
            Some(active) => self.bindings.fit(self.graph.graph(), &active.inputs, frame)?,
            None => false,
        };
        if !fits {
            let inputs = self.bindings.inputs(self.graph.graph(), frame)?;
            self.fade.end(&mut self.executor, FadeSkipReason::NewImages);
            self.load_for(inputs)?;
            return Ok(None);
        }
        self.executor.recover();
        if frame.kind == FrameKind::Cut || self.executor.is_fresh() || self.fade.has_lost_frames() {
            self.fade.end(&mut self.executor, FadeSkipReason::NewBeginning);
        }
        let mut failure = None;
        // A plan waits for the end of a fade.
        if !self.fade.is_running()
            && let Some(creation) = self.graph.next_plan.take_finished()
        {
            failure = self.activate(creation, Some(frame)).err();
        }
        if let PlanState::Queued = self.graph.next_plan {
            self.start_next_plan();
        }
        Ok(failure.or_else(|| self.prepare_ahead(None).err()))
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
    ) -> Result<(), PostError> {
        self.update_uniforms();
        if let Some(values) = self.fade.old_revision().and_then(|revision| self.graph.values_of(revision)) {
            self.fade.update_old(values);
        }
        self.fade.record(&mut self.executor, encoder, frame, draws)?;
        self.frame += 1;
        let plan = self.active.as_ref().map(|active| &active.plan);
        Ok(self.readings.record(&self.executor, plan, self.frame, encoder)?)
    }

    /// Updates the uniforms of the active plan. If a value needs another plan, that is queued.
    fn update_uniforms(&mut self) {
        let Some(active) = &mut self.active else { return };
        let revision = active.revision();
        let updated = self.graph.values_of(revision).map_or(Ok(()), |values| active.update(values));
        active.write(&mut self.executor);
        // The next plan of a graph that has been replaced is on its way.
        if updated == Err(NeedsPlan) && revision == self.graph.revision.graph {
            self.graph.replan();
        }
        self.drop_unused_graphs();
    }

    /// Drops graphs that have been replaced and of which no plan renders any more.
    fn drop_unused_graphs(&mut self) {
        let active = self.active.as_ref().map(ActivePlan::revision);
        let fading = self.fade.old_revision();
        let unused = self.graph.take_unused(|revision| [active, fading].contains(&Some(revision)));
        if !unused.is_empty() {
            self.executor.drop_later(unused);
        }
    }

    /// Makes the plan for the host's inputs and loads it, if it is not the active one.
    ///
    /// # Errors
    /// The graph cannot be planned for them, or the device refuses the plan.
    pub(crate) fn load_for(&mut self, inputs: HostInputs) -> Result<&Arc<Plan>, PostError> {
        // A plan for these images that is being made need not be made twice.
        let prepared = self.prepare_ahead(Some(&inputs));
        if let PlanState::Creating(_) = self.graph.next_plan {
            self.graph.next_plan = PlanState::Queued;
        }
        let planned = self.graph.plan(&self.executor, inputs.clone())?;
        // What that plan is made of may have changed since: then only this one counts.
        drop(prepared);
        if self.active.as_ref().is_none_or(|active| !Arc::ptr_eq(&active.plan, &planned.plan)) {
            let active = ActivePlan::new(inputs, &planned, self.graph.values());
            self.executor.load_with(active.plan.clone(), active.uniforms.clone())?;
            if self.active.replace(active).is_some() {
                self.fade.skip(FadeSkipReason::NewImages);
            }
        }
        self.graph.next_plan = PlanState::Ok;
        self.names.queue();
        Ok(self.plan().expect("it is loaded"))
    }

    /// The plan for these inputs of the host, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned for them.
    pub fn plan_for(&mut self, inputs: HostInputs) -> Result<Arc<Plan>, PlanError> {
        Ok(self.graph.plan(&self.executor, inputs)?.plan.clone())
    }

    /// The plan for these inputs of the host, whatever the device has for images: to be made in bands.
    pub(crate) fn plan_in_bands(&self, inputs: HostInputs) -> Result<Plan, PlanError> {
        self.graph.plan_request(&self.executor, inputs).with(|request| {
            let (given, facts, dynamic) = (request.given.clone(), request.facts.clone(), request.dynamic.clone());
            let caps = Caps { max_side: u32::MAX, max_memory: u64::MAX, ..request.caps.clone() };
            let options = Options { alias: Alias::None, ..request.options };
            let requirement = request.requirement;
            plan(self.graph.graph(), &PlanRequest { given, facts, caps, options, dynamic, requirement })
        })
    }

    /// Starts to create the queued plan on a worker, unless the active one is the same.
    fn start_next_plan(&mut self) {
        self.graph.next_plan = PlanState::Ok;
        let Some(active) = &self.active else { return };
        let request = self.graph.plan_request(&self.executor, active.inputs.clone());
        let cached = self.graph.cached(&request);
        if cached.as_ref().is_some_and(|cached| Arc::ptr_eq(&cached.plan, &active.plan)) {
            return;
        }
        let (graph, revision) = (self.graph.shared(), self.graph.revision);
        let changes = self.graph.changes().clone();
        let (compile, prepare_fade) = (self.executor.compilation(), self.fade.preparation(&self.executor, active));
        let worker = Worker::new(self.executor.task_pool(), move || {
            span!("afterimage::prepare");
            let (planned, uncached) = match cached {
                Some(planned) => (planned, None),
                None => {
                    let uncached = request.plan(&graph)?;
                    (uncached.planned.clone(), Some(uncached))
                }
            };
            let values = GraphValues { graph: &graph, revision: revision.graph, changes: &changes };
            let active = ActivePlan::new(request.inputs, &planned, values);
            let prepared = compile(active.plan.clone(), active.uniforms.clone())?;
            Ok(CreatedPlan { active, prepared, uncached, fade: prepare_fade.map(|prepare| prepare()) })
        });
        self.graph.next_plan.start(revision, worker);
    }

    /// Installs a plan that a worker has created. `frame` is its first frame, or `None` if the host waits for the plan.
    fn activate(&mut self, creation: Creation<CreatedPlan>, frame: Option<&Frame<'_>>) -> Result<(), PostError> {
        if creation.revision.graph != self.graph.revision.graph {
            // A plan for the present graph follows.
            self.executor.drop_later(creation.worker);
            return Ok(());
        }
        let CreatedPlan { active, prepared, uncached, fade } = creation.worker.join()??;
        let fade = self.fade.before_change(&self.executor, self.active.as_ref(), &active.plan, frame, fade);
        self.names.queue();
        let old_memory = self.executor.install(prepared)?;
        let evicted = uncached.and_then(|uncached| self.graph.keep(uncached, creation.revision));
        let old = self.active.replace(active);
        let old = old.and_then(|old| self.fade.start(&self.executor, fade, old));
        self.executor.drop_later((old_memory, old, evicted));
        Ok(())
    }

    /// Waits for the plan that the present facts and values need, and activates it. A [fade](Self::set_fade) ends.
    ///
    /// # Errors
    /// It cannot be made, or the device refuses it: the old plan renders on.
    pub fn finish_changes(&mut self) -> Result<(), PostError> {
        self.fade.end(&mut self.executor, FadeSkipReason::Awaited);
        while self.is_changing() && self.active.is_some() {
            if let Some(creation) = self.graph.next_plan.take() {
                self.activate(creation, None)?;
            }
            if let PlanState::Queued = self.graph.next_plan {
                self.start_next_plan();
            }
        }
        Ok(())
    }

    /// Makes and compiles the plans of frames like these in the background, also before the first frame, and again
    /// after each change of facts, tiers and pipelines. A frame that is like one of them then needs memory for its
    /// images only. They replace those of the call before; none are forgotten by an empty list.
    ///
    /// ```no_run
    /// # use afterimage_gpu::{ExpectedFrame, HostImage, Post, PostError, wgpu::TextureFormat};
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
        let frames: Vec<KeptFrame> = frames.iter().map(KeptFrame::from).collect();
        for frame in &frames {
            self.bindings.inputs(self.graph.graph(), frame)?;
        }
        self.ahead = PlansAhead::new(frames);
        self.prepare_ahead(None)
    }

    /// Whether the plans of all frames of [`prepare`](Self::prepare) are made and compiled. Each call, and each frame,
    /// takes a plan that is finished and starts the next.
    ///
    /// # Errors
    /// A plan cannot be made: once for each.
    pub fn is_prepared(&mut self) -> Result<bool, PostError> {
        self.prepare_ahead(None)?;
        Ok(self.ahead.are_ready(self.graph.version()))
    }

    /// Caches the plan of an announced frame if it is finished, or waits for that of these inputs. Starts the next.
    ///
    /// # Errors
    /// A plan cannot be made.
    fn prepare_ahead(&mut self, wanted: Option<&HostInputs>) -> Result<(), PostError> {
        if let Some((ahead, creation)) = self.ahead.take(wanted) {
            let (plan, uncached) = creation.worker.join().map_err(PostError::from).flatten()?;
            ahead.note_compiled(&plan);
            let evicted = uncached.and_then(|uncached| self.graph.keep(uncached, creation.revision));
            if let Some(evicted) = evicted {
                self.executor.drop_later(evicted);
            }
        }
        let version = self.graph.version();
        // The next plan comes first.
        while (self.active.is_none() || matches!(self.graph.next_plan, PlanState::Ok))
            && wanted.is_none()
            && let Some(ahead) = self.ahead.next(version)
        {
            // Another pipeline may have other inputs: its first frame says so.
            let Ok(inputs) = self.bindings.inputs(self.graph.graph(), &ahead.frame) else {
                ahead.finish(version);
                continue;
            };
            let request = self.graph.plan_request(&self.executor, inputs.clone());
            let cached = self.graph.cached(&request);
            if cached.as_ref().is_some_and(|cached| ahead.has_compiled(&cached.plan)) {
                ahead.finish(version);
                continue;
            }
            let (graph, compile) = (self.graph.shared(), self.executor.compilation_ahead(ahead.frame.drawn()));
            let worker = Worker::new(self.executor.task_pool(), move || {
                span!("afterimage::prepare");
                let (plan, uncached) = match cached {
                    Some(cached) => (cached.plan.clone(), None),
                    None => {
                        let uncached = request.plan(&graph)?;
                        (uncached.planned.plan.clone(), Some(uncached))
                    }
                };
                compile(&plan)?;
                Ok((plan, uncached))
            });
            ahead.start(inputs, version, self.graph.revision, worker);
        }
        Ok(())
    }

    /// All parameters of the graph.
    pub fn parameters(&self) -> impl Iterator<Item = ParameterInfo<'_>> {
        self.graph().parameters().map(|id| ParameterInfo {
            name: self.graph().parameter_name(id),
            declaration: self.graph().declaration(id),
            value: self.graph().value(id),
        })
    }

    /// The parameters of the present graph that the host has set, or has handles of and may set without a plan: their
    /// names, `node.parameter`, and their values.
    pub fn set_values(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.graph.set_values()
    }

    /// A handle to the parameter that `node.parameter` names.
    ///
    /// The parameter is dynamic from the next plan on: its node runs also where its value changes nothing, so that new
    /// values need no plan. Where a change [needs a plan](Self::needs_plan), each does.
    ///
    /// # Errors
    /// There is no such parameter, or it has another type.
    pub fn parameter<T: ParamType>(&mut self, name: &str) -> Result<Parameter<T>, PostError> {
        self.graph.parameter(name)
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// There is no such parameter.
    pub fn control(&mut self, name: &str) -> Result<Control, PostError> {
        self.graph.control(name)
    }

    /// Sets a value, from the next frame on; in the background if it needs a new plan. While the present graph has no
    /// such parameter, the value is kept for the next one.
    ///
    /// # Errors
    /// It is outside of the domain, or does not go with other values of the node, which then keeps the old one.
    pub fn set<T: ParamType>(&mut self, parameter: Parameter<T>, value: T) -> Result<(), PostError> {
        self.set_value(parameter.control(), value.into_value())
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// As [`set`](Self::set); also if the value has another type.
    pub fn set_value(&mut self, control: Control, value: Value) -> Result<(), PostError> {
        self.graph.set_value(control, value)
    }

    /// The present value of a parameter: that of the graph, or the last that was set while the graph has none.
    pub fn value(&self, control: Control) -> Option<&Value> {
        self.graph.value(control)
    }

    /// Reverts to the value in the pipeline file, also in the next graph.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn unset(&mut self, control: Control) -> Result<(), PostError> {
        self.graph.unset(control)
    }

    /// Whether a change of the parameter needs a new plan.
    pub fn needs_plan(&self, control: Control) -> bool {
        self.graph.needs_plan(control)
    }

    /// Fades from the old plan to the new one over this many frames after each change that is made in the background,
    /// at most 65,534; 0, the default, changes at once. Both plans render in these frames, each with histories and
    /// adaptation of its own, and frame `k` of `n` has `k / (n + 1)` of the new output: of its encoded values where the
    /// host's image holds those, of its light where it holds light. The frame before them is of the old plan alone, and
    /// the frame after them of the new plan alone, bit for bit what it would be without a fade.
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

    /// Whether the next frame is a mix of two plans, unless something ends the fade.
    pub fn is_fading(&self) -> bool {
        self.fade.is_running()
    }

    /// Why the last change was not faded, or not to its end. `None` if it was, if there was none, and without
    /// [`set_fade`](Self::set_fade).
    pub fn fade_skip_reason(&self) -> Option<&FadeSkipReason> {
        self.fade.skip_reason.as_ref()
    }

    /// The number of the last frame that shaders saw, from which noise is made.
    pub fn noise_number(&self) -> u32 {
        self.executor.last_number()
    }

    /// The number of frames that have been recorded: that of the last one, counted from 1.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Reads a table or value of a node, `node.port`, back after every frame from now on, without a wait. A node that
    /// the plan does not run has none.
    pub fn watch(&mut self, label: &str) -> Watch {
        self.names.queue();
        self.readings.watch(label)
    }

    /// The newest reading that has arrived: a few frames old, because nothing waits for it. Readings arrive while
    /// frames are recorded and submitted, and the device is polled.
    ///
    /// # Errors
    /// The watch is of another pipeline.
    pub fn reading(&self, watch: Watch) -> Result<Option<&Reading>, PostError> {
        self.readings.latest(watch)
    }

    /// Measures the GPU time of each pass of every frame from now on, without a wait. `false` where the device has no
    /// timestamps inside passes, and before a plan is loaded. A measured frame is a little slower, because the passes
    /// of a batch do not overlap.
    ///
    /// # Errors
    /// The device is lost or has no memory for the timestamps.
    pub fn time_passes(&mut self) -> Result<bool, GpuError> {
        self.executor.enable_timing()
    }

    /// The newest times of passes that have arrived, if they are [measured](Self::time_passes): a few frames old, like
    /// a [`reading`](Self::reading).
    pub fn pass_times(&self) -> Option<&PassTimes> {
        self.readings.pass_times.latest.as_ref()
    }

    /// The texture of an image of the plan that renders, by its label, `node.port`, or by its name in
    /// [`Plan::image_names`]. It holds the texels of the last frame where the plan shares no memory:
    /// [`Alias::None`](afterimage_plan::Alias::None). `None` for images of the host, and for those that no pass uses.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        self.executor.image(name)
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
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn buffer(&self, label: &str) -> Option<&wgpu::Buffer> {
        self.executor.buffer(label)
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
