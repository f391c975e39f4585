//! The slow part of loading a plan, on any thread while another plan renders: shaders, pipelines, memory, and the bind
//! groups without an image of the host.

mod allocate;
pub(crate) mod compiled;

use std::sync::Arc;

use afterimage_graph::node::{BufferLife, Pass, Resource};
use afterimage_plan::codegen::{CodeOptions, Composed, SlotKind};
use afterimage_plan::{Alias, HeapPlacement, PlacedPlan, Plan, PlannedImage, Stage};
use wgpu::{Device, Queue, TextureFormat};

use crate::error::GpuError;
use crate::executor::bind::binder::Binder;
use crate::executor::bind::builder::BindGroupBuilder;
use crate::executor::load::allocate::{NewResidency, ResidencyBuilder, ring_length};
use crate::executor::load::compiled::CompiledPasses;
use crate::executor::loaded::bind_group_cache::BindGroupCache;
use crate::executor::loaded::due_passes::{DuePasses, WrittenBuffer};
use crate::executor::loaded::explicit_transitions::ExplicitTransitions;
use crate::executor::loaded::previous::PreviousPlan;
use crate::executor::loaded::redraw::Redraw;
use crate::executor::loaded::residency::Residency;
use crate::executor::loaded::uniforms::Uniforms;
use crate::executor::loaded::{HostViews, LoadedPass, LoadedPasses, LoadedPlan, planned_attachment};
use crate::heap::{Place, Placed};
use crate::pipelines::{Built, PipelineRequest, Pipelines};
use crate::platform::{TaskPool, Worker, watched};

/// A plan that is being compiled in the background, from [`Executor::prepare`](crate::Executor::prepare). If it is
/// dropped, the pipelines that it has compiled until then are kept.
pub struct Preparation {
    pub(crate) worker: Worker<Result<PreparedPlan, GpuError>>,
}

impl Preparation {
    /// True if [`Executor::swap`](crate::Executor::swap) returns without waiting, with the plan or an error.
    pub fn is_ready(&self) -> bool {
        self.worker.is_finished()
    }
}

/// A compiled plan that can be installed, with its uniforms at the values of dynamic parameters.
pub struct PreparedPlan {
    pub(crate) plan: Arc<Plan>,
    pub(crate) uniforms: Vec<u8>,
    pub(crate) memory: PreparedMemory,
}

/// The progress of preparing the memory of a plan.
pub(crate) enum PreparedMemory {
    /// The plan takes all of it from this one, from which it differs in values of uniforms only.
    UniformsOnly(Arc<Plan>),
    /// It is allocated, with what can be reused of the memory of the plan in use.
    Allocated { loaded: Box<LoadedPlan>, previous: Option<Arc<Residency>> },
    /// Not at all: which texture of a history is the newest is known in the frame that installs the plan.
    PassesOnly,
}

/// The time at which a plan is prepared.
#[derive(Clone, Copy)]
pub(crate) enum Preparing {
    /// The next frame, which has this number, waits for the plan.
    NextFrame(u32),
    /// Frames of the plan in use are recorded meanwhile.
    InBackground,
}

/// Compiles plans and allocates their memory.
#[derive(Clone)]
pub struct PlanCompiler {
    /// The host's device.
    pub device: Device,
    pub(crate) queue: Queue,
    pub(crate) binder: Binder,
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) compiled: Arc<CompiledPasses>,
    /// The host's task pool, if it has one: plans are compiled there, and not on the crate's threads.
    pub pool: Option<TaskPool>,
    /// The way in which passes of this device read their numbers.
    pub(crate) code: CodeOptions,
    /// The error of the device when the executor was made, if there was one.
    pub(crate) broken: Option<GpuError>,
}

impl PlanCompiler {
    /// Drops a value on another thread, because freeing memory takes as long as allocating it.
    pub fn drop_later<T: Send + 'static>(&self, left: T) {
        drop(Worker::new(self.pool.as_ref(), move || drop(left)));
    }

    /// Compiles the passes of a plan that may be loaded later, on any thread. `drawn` are the formats of the host's
    /// images for outputs.
    pub fn ahead(
        &self,
        drawn: Vec<(String, TextureFormat)>,
    ) -> impl FnOnce(&Arc<Plan>) -> Result<(), GpuError> + Send + use<> {
        let compiler = self.clone();
        move |plan| compiler.passes(plan, &PreviousPlan { drawn, ..PreviousPlan::default() }, 1).map(drop)
    }

    /// Compiles the plan with this many threads, and allocates its memory and the bind groups without an image of the
    /// host. Its images keep their offsets in the heap where those still fit.
    pub(crate) fn prepare(
        &self,
        plan: Arc<Plan>,
        uniforms: Vec<u8>,
        before: &PreviousPlan,
        threads: usize,
        when: Preparing,
    ) -> Result<PreparedPlan, GpuError> {
        span!("afterimage::compile");
        if let Some(error) = &self.broken {
            return Err(error.clone());
        }
        let can_stay = |(old, _): &&(Arc<Plan>, Arc<Residency>)| old.differs_in_uniforms_only(&plan);
        if let Some((old, _)) = before.plan.as_ref().filter(can_stay) {
            return Ok(PreparedPlan { plan, uniforms, memory: PreparedMemory::UniformsOnly(old.clone()) });
        }
        let passes = self.passes(&plan, before, threads)?;
        let previous = before.plan.as_ref().map(|(_, residency)| residency.clone());
        let frame = match when {
            Preparing::NextFrame(number) => number,
            Preparing::InBackground => {
                if previous.as_ref().is_some_and(|old| !old.keeps_places(ring_length(&plan))) {
                    return Ok(PreparedPlan { plan, uniforms, memory: PreparedMemory::PassesOnly });
                }
                0
            }
        };
        let mut loaded = watched(&self.device, "the memory of the plan", || {
            self.allocate(plan.clone(), &uniforms, passes, before, frame)
        })?;
        if let Preparing::InBackground = when {
            loaded.is_watched = true;
            if let Some(groups) = self.bind_groups(&loaded).ahead(before) {
                loaded.bind_groups.add(groups);
            }
        }
        let memory = PreparedMemory::Allocated { loaded: Box::new(loaded), previous };
        Ok(PreparedPlan { plan, uniforms, memory })
    }

    /// Allocates a plan's textures and buffers, reusing those of the previous plan with equal descriptors. `frame` is
    /// the number of the next frame, where it matters: see [`Residency::keeps_places`].
    fn allocate(
        &self,
        plan: Arc<Plan>,
        uniforms: &[u8],
        passes: LoadedPasses,
        before: &PreviousPlan,
        frame: u32,
    ) -> Result<LoadedPlan, GpuError> {
        let old = before.plan.as_ref().map(|(plan, residency)| (&**plan, &**residency));
        let PlacedPlan { plan, placement } = keep_places(plan, before);
        let old_heap = old.and_then(|(_, residency)| residency.placed.as_ref());
        let placed = self.place(&plan, &placement, old_heap);
        let same = |old: &Placed| placed.as_ref().is_some_and(|placed| Arc::ptr_eq(&placed.heap, &old.heap));
        let shares_old_heap = old_heap.is_some_and(same);
        let due = DuePasses::new(&plan, uniforms);
        let uniforms = Uniforms::new(&self.device, uniforms)?;
        let builder = ResidencyBuilder { device: &self.device, queue: &self.queue, old, frame };
        let NewResidency { residency, uninitialized } = builder.allocate(&plan, placement, placed)?;
        let is_drawn = passes.iter().map(|pass| {
            pass.built.pipeline.stage() != Stage::Compute || before.format_of(&plan, pass.writes_image).is_some()
        });
        let explicit_transitions = Arc::new(ExplicitTransitions::new(&plan, &residency, is_drawn.collect()));
        let drawn = self.drawn(&plan, &passes, before)?;
        let persistent = buffers_that_live(&plan, &BufferLife::Persistent);
        let mut loaded = LoadedPlan {
            zeroed: buffers_that_live(&plan, &BufferLife::Zeroed),
            redraw: Redraw::new(&self.device, &plan, &residency.buffers, &persistent),
            persistent,
            host_views: host_views(&plan, &residency),
            in_rings: plan.work().map(|pass| binds_history(pass, &residency)).collect(),
            scissors: vec![None; plan.outputs.len()],
            plan,
            residency,
            passes,
            uniforms,
            due,
            bound: Vec::new(),
            drawn,
            is_watched: false,
            explicit_transitions,
            bind_groups: BindGroupCache::default(),
            timing: None,
            labels: None,
            frame_offsets: self.binder.frame_offsets,
            uninitialized,
            shares_old_heap,
            last_index: 0,
        };
        let mut bound = Vec::with_capacity(loaded.passes.len());
        for (index, pass) in loaded.passes.iter().enumerate() {
            let is_bound = loaded.host_views[index].is_empty();
            bound.push(is_bound.then(|| Arc::new(self.binder.bind_pass(&loaded, index, pass.built.clone(), &[]))));
        }
        loaded.bound = bound;
        Ok(loaded)
    }

    /// Makes bind groups for a plan that is loaded.
    pub(crate) fn bind_groups<'a>(&'a self, loaded: &'a LoadedPlan) -> BindGroupBuilder<'a> {
        BindGroupBuilder { binder: &self.binder, pipelines: &self.pipelines, loaded }
    }

    /// The compiled passes of a plan.
    pub(crate) fn passes(
        &self,
        plan: &Arc<Plan>,
        before: &PreviousPlan,
        threads: usize,
    ) -> Result<LoadedPasses, GpuError> {
        if let Some(known) = self.compiled.get(plan) {
            let requests = Self::requests(plan, known.iter().map(|pass| &pass.composed), before, false);
            self.pipelines.build(&self.device, requests, threads, self.pool.as_ref())?;
            return Ok(known);
        }
        let composed: Vec<Composed> = (0..plan.passes.len())
            .map(|index| plan.compose(index, self.code).map_err(|error| GpuError::Shader(error.into())))
            .collect::<Result<_, _>>()?;
        let requests = Self::requests(plan, composed.iter(), before, true);
        let pipelines = self.pipelines.build(&self.device, requests, threads, self.pool.as_ref())?;
        let mut passes = Vec::with_capacity(composed.len());
        for (index, composed) in composed.into_iter().enumerate() {
            let writes_image = plan.passes[index].pass.written_image();
            let attachment = planned_attachment(plan, index, writes_image);
            let key = PipelineRequest::new(plan, index, &composed, attachment).key;
            passes.push(LoadedPass {
                workgroups: plan.passes[index].workgroups,
                writes_image,
                immediate: composed.immediate,
                binds_frame: composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame),
                built: pipelines[&key].clone(),
                composed,
            });
        }
        let passes = LoadedPasses::from(passes);
        self.compiled.put(plan, &passes);
        Ok(passes)
    }

    /// The pipelines that passes may need: those for the host's images, and the planned ones if these are asked for.
    fn requests<'c>(
        plan: &Plan,
        composed: impl Iterator<Item = &'c Composed>,
        before: &PreviousPlan,
        has_planned: bool,
    ) -> Vec<PipelineRequest> {
        let mut requests = Vec::new();
        for (index, composed) in composed.enumerate() {
            let image = plan.passes[index].pass.written_image();
            if has_planned {
                requests.push(PipelineRequest::new(plan, index, composed, planned_attachment(plan, index, image)));
            }
            if let Some(format) = before.format_of(plan, image).filter(|_| is_drawable(plan, index)) {
                requests.push(PipelineRequest::new(plan, index, composed, Some(format)));
            }
        }
        requests
    }

    /// The pipelines that draw into the host's images, if those have the formats of the frame before.
    fn drawn(
        &self,
        plan: &Plan,
        passes: &LoadedPasses,
        before: &PreviousPlan,
    ) -> Result<Vec<(usize, TextureFormat, Built)>, GpuError> {
        let mut drawn = Vec::new();
        for (index, pass) in passes.iter().enumerate() {
            if let Some(format) = before.format_of(plan, pass.writes_image).filter(|_| is_drawable(plan, index)) {
                drawn.push((index, format, self.pipelines.drawing(&self.device, plan, index, &pass.composed, format)?));
            }
        }
        Ok(drawn)
    }

    /// The plan's transient images in one heap, where the plan and the backend allow it.
    fn place<'p>(&self, plan: &'p Plan, placement: &HeapPlacement, old: Option<&Placed>) -> Option<Placed> {
        let place = |(image, offset): (&'p PlannedImage, &Option<u64>)| {
            let (offset, planned) = ((*offset)?, image.requirement.expect("an image in the heap has a requirement"));
            Some(Place { offset, desc: image.desc, planned, label: &image.label })
        };
        let places: Vec<Place<'_>> = plan.images.iter().zip(&placement.offsets).filter_map(place).collect();
        if plan.options.alias != Alias::Placed || places.is_empty() {
            return None;
        }
        Placed::new(&self.device, placement.heap, &places, old)
    }
}

fn keep_places(plan: Arc<Plan>, before: &PreviousPlan) -> PlacedPlan {
    match before.plan.as_ref().filter(|(_, old)| old.placed.is_some()) {
        Some((old, residency)) => {
            PlacedPlan::keeping(plan, &PlacedPlan { plan: old.clone(), placement: residency.placement.clone() })
        }
        None => PlacedPlan::new(plan),
    }
}

/// The buffers of this life.
fn buffers_that_live(plan: &Plan, life: &BufferLife) -> Vec<WrittenBuffer> {
    let buffers = plan.buffers.iter().enumerate().filter(|(_, buffer)| buffer.life == *life);
    buffers.map(|(index, _)| WrittenBuffer::new(plan, index)).collect()
}

/// The host images of each pass.
fn host_views(plan: &Plan, residency: &Residency) -> Vec<HostViews> {
    let places = |resources: Vec<Resource>| {
        let images = resources.into_iter().filter_map(Resource::image);
        images.filter_map(|image| residency.host_view(image)).collect()
    };
    plan.work().map(|pass| HostViews { read: places(pass.reads()), written: places(pass.writes()) }).collect()
}

/// True if a pass binds a history image.
fn binds_history(pass: &Pass, residency: &Residency) -> bool {
    pass.resources().filter_map(Resource::image).any(|image| residency.is_in_ring(image))
}

/// True if a pass can draw its result.
fn is_drawable(plan: &Plan, pass: usize) -> bool {
    plan.passes[pass].pass.kind.is_drawable()
}
