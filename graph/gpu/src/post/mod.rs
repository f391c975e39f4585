//! A pipeline on a device that may belong to somebody else: plans follow the images, the facts and the parameters.

mod error;
mod fade;
mod fade_skip_reason;
mod fading;
mod handle;
mod mix;
mod parameters;
mod pass_times;
mod plans;
mod running;
mod sizes;
mod uniforms;
mod watch;

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_plan::{Options, Plan, PlanCache};
use wgpu::{CommandEncoder, Device, Queue};

use crate::platform::{TaskPool, watched};
use crate::{DrawTargets, Executor, Frame, GpuError, HostDraw};
pub use error::PostError;
pub use fade_skip_reason::FadeSkipReason;
use fading::Fade;
use handle::Handle;
pub use handle::{Control, Parameter, ParameterInfo};
pub use pass_times::PassTimes;
use pass_times::TimedPasses;
use running::{ActivePlan, PendingPlan, Revision, Sizes};
use watch::Watched;
pub use watch::{Reading, Watch};

/// Frames until the device is looked at again.
const FRAMES_BETWEEN_CHECKS: u64 = 32;

/// A graph, its plans, and an executor: what a host keeps for each pipeline that it runs.
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
/// frame can use another one. For everything else the next plan is made and compiled on a thread of its own, while the
/// present one renders, and a later frame swaps it in. What is equal in both plans is kept, also histories.
/// [`set_fade`](Self::set_fade) fades from one to the other.
pub struct Post {
    executor: Executor,
    plans: PlanCache,
    facts: Facts,
    /// The size of the images in rectangles, whatever the rectangles have.
    size: Option<Size>,
    options: Options,
    /// Inputs whose texels are known to be finite.
    finite: BTreeSet<String>,
    /// Outputs that hold linear light.
    linear: BTreeSet<String>,
    handles: Vec<Handle>,
    watched: Vec<Watched>,
    pass_times: TimedPasses,
    /// Frames that have been recorded.
    frame: u64,
    running: Option<ActivePlan>,
    next: Option<PendingPlan>,
    fade: Fade,
    sizes: Sizes,
    /// Whether something has changed since the last plan was asked for.
    is_stale: bool,
    age: Revision,
}

impl Post {
    /// A pipeline on the host's device. [`caps`](crate::caps) says what its plans rely on.
    pub fn new(adapter: &wgpu::Adapter, device: &Device, queue: &Queue, graph: Graph) -> Self {
        Self::with_executor(Executor::with_caps(device, queue, crate::caps(adapter, device)), graph)
    }

    /// The same with an executor that the host has made.
    pub fn with_executor(executor: Executor, graph: Graph) -> Self {
        Self {
            executor,
            plans: PlanCache::new(graph),
            facts: Facts::default(),
            size: None,
            options: Options::default(),
            finite: BTreeSet::new(),
            linear: BTreeSet::new(),
            handles: Vec::new(),
            watched: Vec::new(),
            pass_times: TimedPasses::default(),
            frame: 0,
            running: None,
            next: None,
            fade: Fade::default(),
            sizes: Sizes::default(),
            is_stale: true,
            age: Revision::default(),
        }
    }

    /// The same pipeline for another view: a second camera, window or half of the screen, with images and histories of
    /// its own. Both share what is compiled and planned. Values and facts are those of now, and change apart from then
    /// on; handles are valid for both.
    pub fn clone_for_view(&self) -> Self {
        Self {
            executor: self.executor.clone_for_view(),
            plans: self.plans.clone(),
            facts: self.facts.clone(),
            size: self.size,
            options: self.options,
            finite: self.finite.clone(),
            linear: self.linear.clone(),
            handles: self.handles.clone(),
            watched: self.watched.iter().map(|watched| Watched::new(&watched.label)).collect(),
            pass_times: TimedPasses::default(),
            frame: 0,
            running: None,
            next: None,
            fade: self.fade.for_another(),
            sizes: self.sizes.for_another(),
            is_stale: true,
            age: Revision::default(),
        }
    }

    /// The executor, for timing, resets and read-back.
    pub fn executor(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// The graph at the present values of its parameters.
    pub fn graph(&self) -> &Graph {
        self.plans.graph()
    }

    /// The plan that renders.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.running.as_ref().map(|running| &running.plan)
    }

    /// The attachments of a pass that the host fills, by the name of its node: what its pipelines are made for. `None`
    /// before a plan is loaded, and if the plan has no such pass.
    pub fn draw_targets(&self, node: &str) -> Option<DrawTargets> {
        self.executor.draw_targets(node)
    }

    /// Whether a plan is being made, or will be at the next frame.
    pub fn is_changing(&self) -> bool {
        self.is_stale || self.next.is_some()
    }

    /// Says something about the scene, for the conditions of the pipeline.
    pub fn set_fact(&mut self, name: impl Into<String>, fact: impl Into<Fact>) {
        self.facts.set(name, fact);
        self.is_stale = true;
    }

    /// What the host has said of the scene.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// Replaces all facts.
    pub fn set_facts(&mut self, facts: Facts) {
        self.is_stale |= self.facts != facts;
        self.facts = facts;
    }

    /// Sets the switches of plans.
    pub fn set_options(&mut self, options: Options) {
        self.options = options;
        self.is_stale = true;
    }

    /// States the size in which the pipeline works, whatever the sizes of the [rectangles](Frame::rectangles) of its
    /// inputs: light is filtered to it, and data takes the nearest texel. So a scene may be rendered at another size in
    /// every frame without another plan. With `None` the size is that of the first input's rectangle, and another size
    /// is another plan. Inputs without a rectangle keep their sizes.
    pub fn set_size(&mut self, size: Option<Size>) {
        self.size = size;
    }

    /// Promises that all texels of an input are finite, within ±65504, and negative only where its color state allows
    /// it, so that plans need not sanitize them.
    pub fn assume_finite(&mut self, input: impl Into<String>) {
        self.finite.insert(input.into());
        self.is_stale = true;
    }

    /// States that the image of an output holds linear light, as the main texture of an engine does which is encoded
    /// later: what the pipeline has encoded as sRGB or with a gamma is decoded again, at the end of its last pass. For
    /// an image of an sRGB format this is so anyway.
    pub fn set_output_linear(&mut self, output: impl Into<String>) {
        self.linear.insert(output.into());
    }

    /// Makes plans in the host's task pool from now on, and not on threads of ours. See [`TaskPool`].
    pub fn set_task_pool(&mut self, pool: TaskPool) {
        self.executor.pool = Some(pool);
    }

    /// Replaces the graph: another tier, or another pipeline. Values that the host has set hold in the new graph where
    /// it has their parameters and accepts them; handles stay valid. A graph that differs in values of parameters with
    /// handles alone needs no plan where these need none.
    pub fn change(&mut self, graph: Graph) {
        if self.take_values(&graph) {
            return;
        }
        self.plans = PlanCache::new(graph);
        self.age.graph += 1;
        self.place_handles();
        self.is_stale = true;
    }

    /// Marks each pass with its nodes in the commands, for tools such as RenderDoc. It costs a little time to record.
    pub fn label_passes(&mut self, on: bool) {
        self.executor.label_passes(on);
    }

    /// Goes on on another device, after the one before was lost. Parameters, facts and options stay, histories start
    /// again; the next frame makes its plan and waits for it.
    pub fn rebuild(&mut self, adapter: &wgpu::Adapter, device: &Device, queue: &Queue) {
        let pool = self.executor.pool.take();
        self.executor = Executor::with_caps(device, queue, crate::caps(adapter, device));
        self.executor.pool = pool;
        (self.running, self.next) = (None, None);
        self.end_fade(FadeSkipReason::NewBeginning);
        self.sizes = self.sizes.for_another();
        self.watched.iter_mut().for_each(|watched| watched.readings.renew());
        self.pass_times.renew();
        self.is_stale = true;
    }

    /// Checks that the device is there, at the cost of a buffer of a few bytes.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`].
    pub fn check_device(&self) -> Result<(), GpuError> {
        watched(self.executor.device(), "a check of the device", || Ok(()))
    }

    /// Records a frame into the host's encoder. Submit it before the next is recorded.
    ///
    /// wgpu drops the commands of a lost device without an error, so every 32nd frame looks whether it is there: see
    /// [`check_device`](Self::check_device). [`wgpu::Device::set_device_lost_callback`] says it at once.
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
    /// A pass has its attachments, which the plan makes; the host sets pipelines and bindings. [`draw_targets`] says
    /// what pipelines are made for. Images that the host draws are sanitized where they are read.
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
        let failure = self.update_plan(frame)?;
        self.record(encoder, frame, draws)?;
        failure.map_or(Ok(()), Err)
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
        self.write_uniforms()?;
        self.record_plans(encoder, frame, draws)?;
        self.frame += 1;
        for watched in &mut self.watched {
            watched.readings.collect()?;
            if let Some(buffer) = self.executor.buffer(&watched.label) {
                watched.readings.record(self.executor.device(), buffer, self.frame, encoder)?;
            }
        }
        if let Some(running) = &self.running {
            self.pass_times.record(&self.executor, &running.plan, self.frame, encoder)?;
        }
        Ok(())
    }

    /// The number of frames that have been recorded: that of the last one, counted from 1.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Reads a table or value of a node, `node.port`, back after every frame from now on, without a wait. A node that
    /// the plan does not run has none.
    pub fn watch(&mut self, label: &str) -> Watch {
        let known = self.watched.iter().position(|watched| watched.label == label);
        Watch(known.unwrap_or_else(|| {
            self.watched.push(Watched::new(label));
            self.watched.len() - 1
        }))
    }

    /// The newest reading that has arrived: a few frames old, because nothing waits for it. Readings arrive while
    /// frames are recorded and submitted, and the device is polled. Each frame is submitted before the next is
    /// recorded.
    pub fn reading(&self, watch: Watch) -> Option<&Reading> {
        self.watched[watch.0].readings.latest.as_ref()
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
        self.pass_times.latest.as_ref()
    }

    /// The texture of an image of the plan that renders, by its label, `node.port`, or by its name in
    /// [`Plan::image_names`]. It holds the texels of the last frame where the plan shares no memory:
    /// [`Alias::None`](afterimage_plan::Alias::None). `None` for images of the host, and for those that no pass uses.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        self.executor.image(name)
    }

    /// The texture of an output of the last frame, unless the host gave one.
    ///
    /// # Panics
    /// If the loaded plan has no such output.
    pub fn output(&self, name: &str) -> &wgpu::Texture {
        self.executor.output(name).expect("the executor keeps a texture for each output")
    }

    /// The buffer of a table or value of the loaded plan, by its label.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn buffer(&self, label: &str) -> Option<&wgpu::Buffer> {
        self.executor.buffer(label)
    }
}

// Hosts encode on any thread.
const _: fn() = || {
    fn is_send<T: Send>() {}
    is_send::<Post>();
};
