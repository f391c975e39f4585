//! The executor: records a loaded plan as commands in the host's encoder.

mod bind;
mod fork;
mod frame;
mod frame_counter;
mod host_bindings;
mod host_draw;
mod load;
pub(crate) mod loaded;
mod record;
mod recorded;
mod rectangle;

use std::sync::Arc;

use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::Resource;
use afterimage_plan::{Caps, Plan, Requirement};
use wgpu::{CommandEncoder, Device, Queue};

use crate::cache;
use crate::device::{Gpu, caps};
use crate::error::GpuError;
use crate::frame_constants::{self, FrameConstants};
use crate::heap;
use crate::pipelines::Pipelines;
use crate::platform::{TaskPool, Worker, scoped, watched};
use crate::timing::Timestamps;
use bind::binder::Binder;
pub use bind::host_images::{MULTISAMPLED, VOLUME};
pub use fork::Fork;
pub use frame::view_of;
pub use frame::{Frame, FrameKind};
use frame_counter::{FrameCounter, FrameNumbers};
use host_bindings::HostBindings;
use host_draw::check_filled;
pub use host_draw::{DrawTargets, HostDraw, has_host_draws};
pub use load::Preparation;
pub use load::PreparedPlan;
use load::{PlanCompiler, PreparedMemory, Preparing};
pub use loaded::LoadedPlan;
use loaded::previous::PreviousPlan;
pub use loaded::residency::Residency;
use loaded::uniforms::Staging;
use record::{FrameCommands, clear_memory, separate_from_old_plan};
use recorded::{Lost, RecordedFrames};
pub use rectangle::{Rectangle, color_pass_in};

/// Runs plans on the host's device.
pub struct Executor {
    #[doc(hidden)] // For the crate `afterimage`.
    pub compiler: PlanCompiler,
    caps: Caps,
    staging: Staging,
    loaded: Option<LoadedPlan>,
    #[doc(hidden)] // For the crate `afterimage`.
    pub host: HostBindings,
    #[doc(hidden)] // For the crate `afterimage`.
    pub frames: FrameCounter,
    /// Passes are labeled with their nodes.
    labeled: bool,
    recorded: RecordedFrames,
}

impl Gpu {
    /// An executor with the capabilities of this device. Its executors share the pipelines that are compiled.
    pub fn executor(&self) -> Executor {
        self.executor_with(self.caps.clone())
    }

    /// An executor with all capabilities that the device was opened with, also those that a program has left out of
    /// [`Gpu::caps`].
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn host_executor(&self) -> Executor {
        self.executor_with(caps(&self.adapter, &self.device))
    }

    fn executor_with(&self, caps: Caps) -> Executor {
        let mut executor = Executor::with_caps(&self.device, &self.queue, caps);
        executor.compiler.pipelines = self.pipelines.clone();
        executor
    }
}

impl Executor {
    /// An executor on the host's device, which relies only on what every device has.
    pub fn new(device: &Device, queue: &Queue) -> Self {
        let blends = device.features().contains(wgpu::Features::FLOAT32_BLENDABLE);
        let floats = [Format::R32Float, Format::Rgba32Float].into_iter().filter(|_| blends);
        let caps = Caps {
            blendable: Caps::default().blendable.into_iter().chain(floats).collect(),
            filter_32_bit: device.features().contains(wgpu::Features::FLOAT32_FILTERABLE),
            max_side: device.limits().max_texture_dimension_2d,
            max_volume_side: device.limits().max_texture_dimension_3d,
            ..Caps::default()
        };
        Self::with_caps(device, queue, caps)
    }

    /// An executor that relies on `caps`, from [`caps`](crate::caps). If the device has no memory for it or is lost,
    /// loading a plan returns that error.
    pub fn with_caps(device: &Device, queue: &Queue, caps: Caps) -> Self {
        let mut binder = None;
        let made = watched(device, "the executor", || {
            binder = Some(Binder::new(device));
            Ok(())
        });
        Self {
            compiler: PlanCompiler {
                device: device.clone(),
                queue: queue.clone(),
                binder: binder.expect("it is made above"),
                pipelines: Arc::default(),
                compiled: Arc::default(),
                pool: None,
                code: frame_constants::code_options(device),
                broken: made.err(),
            },
            caps,
            staging: Staging::new(device),
            loaded: None,
            host: HostBindings::default(),
            frames: FrameCounter::default(),
            labeled: false,
            recorded: RecordedFrames::default(),
        }
    }

    /// Another executor on the same device, with images and histories of its own. Both share the pipelines that are
    /// compiled, so that a plan which one has loaded needs only memory in the other.
    pub fn clone_for_view(&self) -> Self {
        self.sharing_compiled()()
    }

    /// Makes an executor that shares what is compiled, on any thread.
    fn sharing_compiled(&self) -> impl FnOnce() -> Self + Send + use<> {
        let (compiler, caps, labeled) = (self.compiler.clone(), self.caps.clone(), self.labeled);
        move || {
            let mut other = Self::with_caps(&compiler.device, &compiler.queue, caps);
            other.compiler.pipelines = compiler.pipelines;
            other.compiler.compiled = compiler.compiled;
            other.compiler.pool = compiler.pool;
            other.labeled = labeled;
            other
        }
    }

    /// The same executor with a cache of the driver's pipelines, which begins with the result of an earlier
    /// [`pipeline_cache_data`](Self::pipeline_cache_data): then the driver need not compile them again. Bytes that are
    /// damaged, or of another adapter, driver or version, are ignored, and so is the cache where the
    /// device has none or no memory for it.
    pub fn with_pipeline_cache(mut self, data: &[u8]) -> Self {
        let device = &self.compiler.device;
        let cache = watched(device, "the pipeline cache", || Ok(cache::open(device, data))).ok().flatten();
        self.compiler.pipelines = Arc::new(Pipelines::with_cache(cache));
        self
    }

    /// The same executor with the host's task pool: plans are prepared and compiled there, and not on the crate's
    /// threads. See [`TaskPool`].
    pub fn with_task_pool(mut self, pool: TaskPool) -> Self {
        self.compiler.pool = Some(pool);
        self
    }

    /// The driver's pipelines as bytes, for the next run of the program; `None` without a cache.
    pub fn pipeline_cache_data(&self) -> Option<Vec<u8>> {
        cache::seal(self.compiler.pipelines.cache.as_ref()?)
    }

    /// The capabilities that plans for this executor may use.
    pub fn caps(&self) -> &Caps {
        &self.caps
    }

    /// The memory that the device requires for an image: the planner gets it through
    /// [`PlanRequest`](afterimage_plan::PlanRequest).
    pub fn requirement(&self, desc: &ImageDesc) -> Requirement {
        heap::requirement(&self.compiler.device, desc)
    }

    /// The plan in use.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.loaded.as_ref().map(|loaded| &loaded.plan)
    }

    /// The plan in use with its memory, and what the last frame has left there.
    pub fn loaded(&self) -> Option<&LoadedPlan> {
        self.loaded.as_ref()
    }

    #[doc(hidden)] // For the crate `afterimage`.
    pub fn loaded_mut(&mut self) -> Option<&mut LoadedPlan> {
        self.loaded.as_mut()
    }

    /// The texture of an output that the host gave no image for.
    pub fn output(&self, name: &str) -> Option<&wgpu::Texture> {
        let LoadedPlan { plan, residency, .. } = self.loaded()?;
        residency.own_output(plan.output(Some(name))?.image).map(wgpu::TextureView::texture)
    }

    /// Compiles and installs a plan before this returns. A program that must not wait between two frames uses
    /// [`prepare`](Self::prepare) and [`swap`](Self::swap).
    ///
    /// On the web, where nothing may wait, errors of the device go to its own error handler, and `prepare` compiles at
    /// once.
    pub fn load(&mut self, plan: Arc<Plan>) -> Result<(), GpuError> {
        let uniforms = plan.uniform_buffer();
        self.load_with(plan, uniforms)
    }

    /// Loads a plan with uniforms at other values.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn load_with(&mut self, plan: Arc<Plan>, uniforms: Vec<u8>) -> Result<(), GpuError> {
        let when = Preparing::NextFrame(self.frames.index);
        let prepared = self.compiler.prepare(plan, uniforms, &self.previous_plan(), cores(), when)?;
        self.install(prepared).map(drop)
    }

    /// Starts to compile a plan on threads of its own, while the plan in use renders. One core is left to the renderer.
    pub fn prepare(&self, plan: Arc<Plan>) -> Preparation {
        let compile = self.compilation();
        let worker = Worker::new(self.compiler.pool.as_ref(), move || {
            let uniforms = plan.uniform_buffer();
            compile(plan, uniforms)
        });
        Preparation { worker }
    }

    /// Compiles a plan on any thread, while the plan in use renders.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn compilation(&self) -> impl FnOnce(Arc<Plan>, Vec<u8>) -> Result<PreparedPlan, GpuError> + Send + use<> {
        let (compiler, previous) = (self.compiler.clone(), self.previous_plan());
        let threads = cores().saturating_sub(1).max(1);
        move |plan, uniforms| compiler.prepare(plan, uniforms, &previous, threads, Preparing::InBackground)
    }

    /// Installs a prepared plan, which renders from the next frame on; waits for it if it is not ready.
    ///
    /// Textures, histories and buffers that are equal in both plans are kept; only memory that is new is initialized as
    /// in a first frame. On an error the old plan stays as it is, with its histories.
    pub fn swap(&mut self, preparation: Preparation) -> Result<(), GpuError> {
        let old = self.install(preparation.worker.join()??)?;
        self.compiler.drop_later(old);
        Ok(())
    }

    /// The parts of the plan in use that the next plan can reuse.
    fn previous_plan(&self) -> PreviousPlan {
        let drawn = self.host.formats.last().to_vec();
        let Some(loaded) = &self.loaded else { return PreviousPlan { drawn, ..PreviousPlan::default() } };
        let (inputs, outputs) = loaded.views_of_host();
        let plan = Some((loaded.plan.clone(), loaded.residency.clone()));
        PreviousPlan { plan, drawn, inputs, outputs }
    }

    /// Installs a plan, which renders from the next frame on, and returns the old one.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn install(&mut self, prepared: PreparedPlan) -> Result<Option<impl Send + use<>>, GpuError> {
        span!("afterimage::load");
        let PreparedPlan { plan, uniforms, memory } = prepared;
        match (memory, &mut self.loaded) {
            (PreparedMemory::UniformsOnly(base), Some(loaded)) if Arc::ptr_eq(&loaded.plan, &base) => {
                loaded.plan = plan;
                loaded.uniforms.set(0, &uniforms);
                Ok(None)
            }
            (PreparedMemory::Allocated { loaded: mut new, previous }, old)
                if previous.as_ref().map(Arc::as_ptr) == old.as_ref().map(|old| Arc::as_ptr(&old.residency)) =>
            {
                new.last_index = self.frames.index.wrapping_sub(1);
                new.labels = self.labeled.then(|| new.plan.pass_names());
                if old.as_ref().is_some_and(|old| old.timing.is_some()) {
                    new.timing =
                        Timestamps::of_passes(&self.compiler.device, &self.compiler.queue, new.passes.len() as u32)?;
                }
                Ok(old.replace(*new))
            }
            // Another plan was loaded meanwhile, or ring indices differ.
            _ => self.load_with(plan, uniforms).map(|()| None),
        }
    }

    /// Labels each pass with its nodes in the commands, for tools such as RenderDoc.
    pub fn label_passes(&mut self, on: bool) {
        self.labeled = on;
        if let Some(loaded) = &mut self.loaded {
            loaded.labels = on.then(|| loaded.plan.pass_names());
        }
    }

    /// Measures the GPU time of each of the plan's passes from now on, in this plan and those after it. `false` before
    /// a plan is loaded, and where the device has no timestamps inside passes.
    ///
    /// # Errors
    /// The device is lost or has no memory for them.
    pub fn enable_timing(&mut self) -> Result<bool, GpuError> {
        let Some(loaded) = &mut self.loaded else { return Ok(false) };
        let PlanCompiler { device, queue, .. } = &self.compiler;
        loaded.timing = Timestamps::of_passes(device, queue, loaded.passes.len() as u32)?;
        Ok(loaded.timing.is_some())
    }

    /// Resets histories and adaptation in the next frame.
    pub fn reset(&mut self) {
        self.frames.is_fresh = true;
    }

    /// Sets the number of the next frame; further ones count on. Noise depends on the number, so frames with equal
    /// numbers have equal grain. Histories and adaptation are reset, because the frame number selects their textures.
    pub fn count_from(&mut self, index: u32) {
        self.frames.count_from(index);
    }

    /// Sets the number that shaders see in the next frame, from which noise is made; further ones count on. Histories
    /// and adaptation go on, so a sequence can begin anywhere and be numbered in any steps.
    pub fn number_next(&mut self, number: u32) {
        self.frames.number_next(number);
    }

    /// For how many passes the last recorded frame has made bind groups: those with a view of the host that the frame
    /// before did not have. An attachment is in no bind group. 0 while the host alternates between a few images.
    pub fn passes_bound(&self) -> usize {
        self.host.made
    }

    /// Notices frames that were recorded and dropped: what later ones rely on is recorded again, and where they began
    /// histories and state, these are reset.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn recover(&mut self) {
        match self.recorded.take_lost() {
            Lost::Nothing => return,
            Lost::Commands => {}
            Lost::State => self.frames.is_fresh = true,
        }
        if let Some(loaded) = &mut self.loaded {
            loaded.invalidate();
        }
    }

    /// Records one frame. Frames are submitted in the order in which they are recorded, each once. If one is not, the
    /// next begins again what it has begun, such as a plan; values of parameters it copies as a cut.
    ///
    /// A lost device is noticed here only in the first frame of a plan. Otherwise wgpu drops the commands, and reading
    /// back reports [`GpuError::DeviceLost`]. A host learns of it from
    /// [`wgpu::Device::set_device_lost_callback`], and loads the plan into an executor on another device.
    ///
    /// # Errors
    /// [`GpuError::NoPlan`] before a plan is loaded; host images that are missing, differ from the plan, or that the
    /// device refuses; [`GpuError::OutOfMemory`].
    pub fn encode(&mut self, encoder: &mut CommandEncoder, frame: &Frame<'_>) -> Result<(), GpuError> {
        self.encode_drawing(encoder, frame, &mut [])
    }

    /// The same with the draws of passes that the host fills; those that the plan does not need are ignored.
    ///
    /// # Errors
    /// As [`encode`](Self::encode), and [`GpuError::MissingDraw`].
    pub fn encode_drawing(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        draws: &mut [HostDraw<'_>],
    ) -> Result<(), GpuError> {
        self.recover();
        let levels = self.host.levels(&self.compiler.device, frame)?;
        let frame = &Frame { levels: &levels, ..*frame };
        let plan = self.plan().ok_or(GpuError::NoPlan)?;
        check_filled(plan, 0..plan.passes.len(), draws)?;
        let numbers = self.frames.next(frame.kind);
        let last = self.loaded.as_ref().and_then(LoadedPlan::last_constants).filter(|_| numbers.is_redraw);
        let constants = last.unwrap_or_else(|| numbers.constants(frame));
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let groups = self.host.bind(&self.compiler, loaded, frame)?;
        loaded.set_host_uniforms(frame)?;
        if !(last.is_some() && self.host.is_same && loaded.choose_dependents()) {
            loaded.choose_passes(numbers.number, (!numbers.resets).then_some(numbers.before));
        }
        self.begin_frame(encoder, constants, last.is_some())?;
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let commands = FrameCommands::new(loaded, groups, numbers.index, &constants);
        commands.clear_zeroed(encoder);
        commands.record(0..loaded.passes.len(), encoder, draws);
        if let Some(timing) = loaded.timing.as_ref().filter(|_| loaded.due.redrawn().is_none()) {
            timing.resolve(encoder);
        }
        let saw_its_state = numbers.resets || loaded.uninitialized.is_empty();
        loaded.set_last_constants(Some(constants).filter(|_| saw_its_state && draws.is_empty()));
        loaded.due.finish(loaded.uniforms.bytes());
        // This frame has initialized all of it.
        loaded.uninitialized.clear();
        loaded.last_index = numbers.index;
        self.frames.finish(numbers, constants);
        Ok(())
    }

    /// Prepares the passes of a frame whose images are bound: the state and the uniforms.
    fn begin_frame(
        &mut self,
        encoder: &mut CommandEncoder,
        constants: FrameConstants,
        restores_state: bool,
    ) -> Result<(), GpuError> {
        let (device, loaded) = (&self.compiler.device, self.loaded.as_mut().ok_or(GpuError::NoPlan)?);
        if constants.reset() || !loaded.uninitialized.is_empty() {
            self.recorded.watch(encoder, Lost::State);
        } else if loaded.is_needed_later() {
            self.recorded.watch(encoder, Lost::Commands);
        }
        if let Some(redraw) = loaded.redraw.as_ref().filter(|_| restores_state) {
            redraw.restore(&loaded.due, encoder);
        } else {
            if constants.reset() {
                loaded.uniforms.invalidate();
                scoped(device, "the cleared histories", || {
                    clear_memory(device, loaded, encoder);
                    Ok::<(), GpuError>(())
                })?;
            }
            loaded.redraw.iter().for_each(|redraw| redraw.save(encoder));
        }
        if std::mem::take(&mut loaded.shares_old_heap) {
            separate_from_old_plan(loaded, encoder);
        }
        if loaded.passes.iter().any(|pass| pass.binds_frame) {
            let has_uninitialized = !loaded.uninitialized.is_empty();
            let binder = &self.compiler.binder;
            binder.write_frame(&constants, has_uninitialized, &mut self.staging, encoder)?;
        }
        // Last, because a frame with an error is not submitted.
        loaded.uniforms.write(device, &mut self.staging, encoder)
    }

    /// Records one pass of a frame and no other, for measurements on devices whose timestamps are not reliable. It
    /// reads what the frames before have left, and the frame number stays.
    pub fn encode_pass(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        pass: usize,
    ) -> Result<(), GpuError> {
        let levels = self.host.levels(&self.compiler.device, frame)?;
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let groups = self.host.bind(&self.compiler, loaded, &Frame { levels: &levels, ..*frame })?;
        loaded.uniforms.write(&self.compiler.device, &mut self.staging, encoder)?;
        loaded.due.choose_only(&[pass]);
        check_filled(&loaded.plan, pass..pass + 1, &[])?;
        let commands = FrameCommands::new(loaded, groups, self.frames.index, &self.frames.constants);
        commands.record(pass..pass + 1, encoder, &mut []);
        loaded.set_last_constants(None);
        Ok(())
    }

    /// Records some passes of a frame, which need no draws of the host, and no other: those of meters make the state
    /// without the rest. What these do not write stays as the frames before have left it; the frame number stays, too.
    /// Unless `frame` resets, state and histories go on.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn encode_passes(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        passes: &[usize],
    ) -> Result<(), GpuError> {
        let numbers = FrameNumbers { resets: frame.kind == FrameKind::Cut, ..self.frames.next(frame.kind) };
        let constants = numbers.constants(frame);
        let levels = self.host.levels(&self.compiler.device, frame)?;
        let frame = &Frame { levels: &levels, ..*frame };
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let groups = self.host.bind(&self.compiler, loaded, frame)?;
        loaded.set_host_uniforms(frame)?;
        loaded.due.choose_only(passes);
        self.begin_frame(encoder, constants, false)?;
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let commands = FrameCommands::new(loaded, groups, numbers.index, &constants);
        commands.clear_zeroed(encoder);
        for &pass in passes {
            commands.record(pass..pass + 1, encoder, &mut []);
        }
        let written: Vec<Resource> = passes.iter().flat_map(|pass| loaded.plan.passes[*pass].pass.writes()).collect();
        loaded.uninitialized.retain(|resource| !written.contains(resource));
        loaded.set_last_constants(None);
        self.frames.is_fresh = false;
        Ok(())
    }
}

/// The number of threads that the processor runs at a time.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
