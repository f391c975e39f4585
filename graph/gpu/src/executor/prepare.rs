//! The slow part of loading a plan, on any thread while another plan runs: shaders, pipelines, memory, and the bind
//! groups that name no image of the host.

use std::sync::Arc;

use afterimage_graph::node::{BufferLife, ImageId, Pass, Resource, Subresource};
use afterimage_plan::codegen::{Composed, SlotKind};
use afterimage_plan::{Alias, HeapPlacement, PlacedPlan, Plan, PlannedImage, Stage};
use wgpu::{BufferUsages, Device, Queue, TextureFormat};

use super::binder::Binder;
use super::compiled::CompiledPasses;
use super::explicit_transitions::ExplicitTransitions;
use super::frame_constants;
use super::host_sets::HostSets;
use super::loaded::{HostViews, Loaded, LoadedPass, LoadedPasses, NamedView, planned_attachment};
use super::rectangle::HeldRectangles;
use super::residency::Residency;
use super::settle::{NewResidency, ResidencyBuilder, ring_length};
use crate::GpuError;
use crate::buffer::filled_buffer;
use crate::drawing::DrawState;
use crate::heap::{Place, Placed};
use crate::layout::manual_filtering;
use crate::pipelines::{Built, PipelineKey, PipelineRequest, Pipelines};
use crate::platform::{Worker, watched};

/// A plan that is being compiled on a thread of its own, from [`Executor::prepare`](crate::Executor::prepare). If it is
/// dropped, the pipelines that it has compiled until then are kept.
pub struct Preparation {
    pub(super) worker: Worker<Result<Prepared, GpuError>>,
}

impl Preparation {
    /// Whether [`Executor::swap`](crate::Executor::swap) would not have to wait, be it for a plan or for an error.
    pub fn is_ready(&self) -> bool {
        self.worker.is_finished()
    }
}

/// A plan that can be swapped in.
pub(crate) enum Prepared {
    /// The plan differs from the running one (the second) only in uniform values.
    UniformsOnly(PlanWithUniforms, Arc<Plan>),
    /// The plan in its memory, if the plan in use is still in this one; and its uniforms.
    Ready(Box<Loaded>, Option<Arc<Residency>>, Vec<u8>),
    /// The passes are compiled; which texture of a history is the newest is known once the plan comes in.
    PassesOnly(PlanWithUniforms),
}

/// A plan that is wanted, and its uniforms at the present values of dynamic parameters.
pub(crate) struct PlanWithUniforms {
    pub(crate) plan: Arc<Plan>,
    pub(crate) uniforms: Vec<u8>,
}

impl From<Arc<Plan>> for PlanWithUniforms {
    fn from(plan: Arc<Plan>) -> Self {
        Self { uniforms: plan.uniform_buffer(), plan }
    }
}

/// What plans are made ready with.
#[derive(Clone)]
pub(super) struct PlanCompiler {
    pub(super) device: Device,
    pub(super) queue: Queue,
    pub(super) binder: Binder,
    pub(super) pipelines: Arc<Pipelines>,
    pub(super) compiled: Arc<CompiledPasses>,
    /// Whether passes take the frame constants from immediates.
    pub(super) immediates: bool,
    /// The error of the device while the executor was made, if there was one.
    pub(super) broken: Option<GpuError>,
}

/// What the next plan can keep of the plan that runs.
#[derive(Clone, Default)]
pub(super) struct PreviousPlan {
    pub(super) plan: Option<(Arc<Plan>, Arc<Residency>)>,
    /// Outputs that the host's images make the last passes draw, and in which format.
    pub(super) drawn: Vec<(String, TextureFormat)>,
    /// The host's images in the last frame, by the names of inputs and of outputs.
    pub(super) inputs: Vec<NamedView>,
    pub(super) outputs: Vec<NamedView>,
}

impl PlanCompiler {
    /// Compiles the plan with this many threads, and gives it its memory and the bind groups that name no image of the
    /// host. Its images keep their places in the heap where those still fit. `frame` is the number of the frame that
    /// comes next, if nothing renders meanwhile.
    pub(super) fn prepare(
        &self,
        wanted: PlanWithUniforms,
        before: &PreviousPlan,
        (threads, frame): (usize, Option<u32>),
    ) -> Result<Prepared, GpuError> {
        span!("afterimage::compile");
        if let Some(error) = &self.broken {
            return Err(error.clone());
        }
        if let Some((old, _)) = before.plan.as_ref().filter(|(old, _)| old.differs_in_uniforms_only(&wanted.plan)) {
            return Ok(Prepared::UniformsOnly(wanted, old.clone()));
        }
        let passes = self.passes(&wanted.plan, before, threads)?;
        let old = before.plan.as_ref().map(|(_, residency)| residency);
        if frame.is_none() && old.is_some_and(|old| !old.keeps_places(ring_length(&wanted.plan))) {
            return Ok(Prepared::PassesOnly(wanted));
        }
        let loaded = watched(&self.device, "the memory of the plan", || self.allocate(&wanted, passes, before, frame))?;
        Ok(Prepared::Ready(Box::new(loaded), old.cloned(), wanted.uniforms))
    }

    /// The plan in memory of its own and of the plan before.
    fn allocate(
        &self,
        wanted: &PlanWithUniforms,
        passes: LoadedPasses,
        before: &PreviousPlan,
        frame: Option<u32>,
    ) -> Result<Loaded, GpuError> {
        let old = before.plan.as_ref().map(|(plan, residency)| (&**plan, &**residency));
        let PlacedPlan { plan, placement } = keep_places(wanted.plan.clone(), before);
        let old_heap = old.and_then(|(_, residency)| residency.placed.as_ref());
        let placed = self.place(&plan, &placement, old_heap);
        let same = |old: &Placed| placed.as_ref().is_some_and(|placed| Arc::ptr_eq(&placed.heap, &old.heap));
        let shares_old_heap = old_heap.is_some_and(same);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniforms = filled_buffer(&self.device, "uniforms", &wanted.uniforms, usage)?;
        let frame_number = frame.unwrap_or_default();
        let settling = ResidencyBuilder { device: &self.device, queue: &self.queue, old, frame: frame_number };
        let NewResidency { residency, uninitialized } = settling.allocate(&plan, placement, placed)?;
        let lives = |wanted: BufferLife| {
            let buffers = plan.buffers.iter().enumerate();
            buffers.filter(|(_, buffer)| buffer.life == wanted).map(|(index, _)| index).collect()
        };
        let is_drawn = passes.iter().map(|pass| {
            pass.built.pipeline.stage() != Stage::Compute || before.format_of(&plan, pass.writes_image).is_some()
        });
        let explicit_transitions = Arc::new(ExplicitTransitions::new(&plan, &residency, is_drawn.collect()));
        let drawn = self.drawn(&plan, &passes, before)?;
        let mut loaded = Loaded {
            zeroed: lives(BufferLife::Zeroed),
            persistent: lives(BufferLife::Persistent),
            host_views: host_views(&plan, &residency),
            in_rings: plan.work().map(|pass| names_ring(pass, &residency)).collect(),
            rectangles: HeldRectangles::none(&plan),
            blocks: plan.blocks.iter().map(|planned| vec![0; planned.block.bytes()]).collect(),
            plan,
            residency,
            passes,
            uniforms,
            runs: Vec::new(),
            drawn,
            is_watched: frame.is_none(),
            explicit_transitions,
            sets: HostSets::default(),
            timing: None,
            labels: None,
            frame_offsets: self.binder.frame_offsets,
            uninitialized,
            shares_old_heap,
        };
        let run = |index: usize| self.binder.run(&loaded, index, loaded.passes[index].built.clone(), &[]);
        let names_none = |index: usize| loaded.host_views[index].is_empty();
        loaded.runs = (0..loaded.passes.len()).map(|index| names_none(index).then(|| Arc::new(run(index)))).collect();
        if frame.is_none() {
            self.set_ahead(&loaded, before).into_iter().for_each(|set| loaded.sets.add(set));
        }
        Ok(loaded)
    }

    /// The passes of a plan: those of before, or compiled.
    pub(super) fn passes(
        &self,
        plan: &Arc<Plan>,
        before: &PreviousPlan,
        threads: usize,
    ) -> Result<LoadedPasses, GpuError> {
        if let Some(known) = self.compiled.get(plan) {
            return Ok(known);
        }
        let dispatches = (0..plan.passes.len())
            .map(|at| UncompiledDispatch::new(plan, at, self.immediates))
            .collect::<Result<Vec<_>, _>>()?;
        let orders = dispatches.iter().enumerate();
        let orders = orders.flat_map(|(at, dispatch)| self.pipeline_requests(plan, at, dispatch, before));
        self.pipelines.build(&self.device, orders.collect(), threads)?;
        let finish = |(at, dispatch)| self.finish(plan, at, dispatch);
        let passes = dispatches.into_iter().enumerate().map(finish).collect();
        self.compiled.put(plan, &passes);
        Ok(passes)
    }

    /// The pipelines that a pass may need: the planned one, and the one for the host's image.
    fn pipeline_requests<'a>(
        &self,
        plan: &'a Plan,
        index: usize,
        dispatch: &'a UncompiledDispatch,
        before: &PreviousPlan,
    ) -> impl Iterator<Item = PipelineRequest<'a>> + use<'a> {
        let extra = before.format_of(plan, dispatch.writes_image).filter(|_| is_drawable(plan, index)).map(Some);
        let planned = planned_attachment(plan, index, dispatch.writes_image);
        let attachments: Vec<_> = std::iter::once(planned).chain(extra).collect();
        attachments
            .into_iter()
            .map(move |attachment| order(plan, index, (&dispatch.composed, dispatch.immediate), attachment))
    }

    fn finish(&self, plan: &Plan, index: usize, dispatch: UncompiledDispatch) -> LoadedPass {
        let UncompiledDispatch { composed, workgroups, writes_image, immediate } = dispatch;
        let attachment = planned_attachment(plan, index, writes_image);
        let key = order(plan, index, (&composed, immediate), attachment).key;
        let built = self.pipelines.get(&key).expect("every planned pipeline was built");
        let manual_filtering = manual_filtering(&composed);
        let binds_frame = composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame);
        LoadedPass { composed, workgroups, writes_image, manual_filtering, immediate, binds_frame, built }
    }

    /// The pipelines that draw into the host's images, if those have the formats of the frame before.
    fn drawn(
        &self,
        plan: &Plan,
        passes: &LoadedPasses,
        before: &PreviousPlan,
    ) -> Result<Vec<(usize, TextureFormat, Built)>, GpuError> {
        let pipeline = |(index, pass): (usize, &LoadedPass)| {
            let format = before.format_of(plan, pass.writes_image).filter(|_| is_drawable(plan, index))?;
            let built = || self.pipelines.drawing(&self.device, (plan, index, pass), format);
            Some(built().map(|built| (index, format, built)))
        };
        passes.iter().enumerate().filter_map(pipeline).collect()
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

impl PreviousPlan {
    /// The format in which the host's image makes the pass that writes this image draw.
    fn format_of(&self, plan: &Plan, image: Option<ImageId>) -> Option<TextureFormat> {
        let output = plan.outputs.iter().find(|output| Some(output.image) == image)?;
        self.drawn.iter().find(|(name, _)| *name == output.name).map(|(_, format)| *format)
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

/// For each pass the places of the images that it names among the host's views.
fn host_views(plan: &Plan, residency: &Residency) -> Vec<HostViews> {
    let places = |resources: Vec<Resource>| {
        let images = resources.into_iter().filter_map(Resource::image);
        images.filter_map(|image| residency.host_view(image)).collect()
    };
    plan.work().map(|pass| HostViews { read: places(pass.reads()), written: places(pass.writes()) }).collect()
}

/// Whether a pass names an image in a ring.
fn names_ring(pass: &Pass, residency: &Residency) -> bool {
    pass.resources().filter_map(Resource::image).any(|image| residency.is_in_ring(image))
}

/// Whether a pass can draw its result.
fn is_drawable(plan: &Plan, pass: usize) -> bool {
    plan.passes[pass].pass.kind.is_drawable()
}

impl Pipelines {
    /// The pipeline that draws a pass's result into an image of this format.
    pub(super) fn drawing(
        &self,
        device: &Device,
        (plan, index, pass): (&Plan, usize, &LoadedPass),
        format: TextureFormat,
    ) -> Result<Built, GpuError> {
        let order = order(plan, index, (&pass.composed, pass.immediate), Some(format));
        let key = order.key.clone();
        self.build(device, vec![order], 1)?;
        Ok(self.get(&key).expect("it was built above"))
    }
}

/// A pass whose pipeline is not compiled yet.
struct UncompiledDispatch {
    composed: Composed,
    workgroups: [u32; 3],
    writes_image: Option<ImageId>,
    immediate: bool,
}

impl UncompiledDispatch {
    fn new(plan: &Plan, index: usize, immediates: bool) -> Result<Self, GpuError> {
        let composed = plan.compose(index, immediates).map_err(GpuError::Shader)?;
        let writes_image = plan.passes[index].pass.written_image();
        let (immediate, workgroups) = (composed.immediate, plan.passes[index].workgroups);
        Ok(Self { composed, workgroups, writes_image, immediate })
    }
}

/// The pipeline of a pass, which takes the frame constants from immediates or not; drawn if there is an attachment.
fn order<'a>(
    plan: &'a Plan,
    index: usize,
    (composed, immediate): (&'a Composed, bool),
    attachment: Option<TextureFormat>,
) -> PipelineRequest<'a> {
    let pass = &plan.passes[index].pass;
    let stage = match attachment {
        _ if pass.drawing().is_some() => Stage::Drawing,
        Some(_) => Stage::Fragment,
        None => Stage::Compute,
    };
    let drawing = pass.drawing().map(|drawing| DrawState::new(plan, drawing));
    let sample_modes = composed.slots.iter().map(|slot| match slot.kind {
        SlotKind::Texture(image) | SlotKind::Level(Subresource { image, .. }) => {
            format!("{:?}", plan.image(image).sample_mode)
        }
        _ => String::new(),
    });
    let layout: Vec<String> = sample_modes.collect();
    PipelineRequest {
        key: PipelineKey {
            source: composed.source.clone(),
            entry: composed.compute.clone(),
            attachment,
            drawing,
            layout: layout.join(","),
            checked: plan.options.bounds_checks || !composed.unchecked,
        },
        plan,
        composed,
        stage,
        immediate_bytes: if immediate { frame_constants::BYTES } else { 0 },
        label: pass.label.clone(),
        zero_workgroup_memory: composed.zero_workgroup_memory,
    }
}
