//! The slow part of loading a plan, on any thread while another plan runs: shaders, pipelines, and the images of its
//! heap.

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Subresource};
use afterimage_plan::codegen::{Composed, SlotKind};
use afterimage_plan::{Alias, HeapPlacement, PlacedPlan, Plan, PlannedImage, Stage};
use wgpu::{Buffer, BufferUsages, Device, TextureFormat};

use super::compiled::CompiledPasses;
use super::frame_constants;
use super::loaded::{LoadedPass, LoadedPasses, planned_attachment};
use crate::GpuError;
use crate::buffer::filled_buffer;
use crate::drawing::DrawState;
use crate::heap::{Place, Placed};
use crate::layout::by_hand;
use crate::pipelines::{Order, PipelineKey, Pipelines};
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
    Numbers(Arc<Plan>, Arc<Plan>),
    Whole(Box<CompiledPlan>),
}

/// What a plan needs that no other plan has.
pub(crate) struct CompiledPlan {
    pub(super) plan: Arc<Plan>,
    pub(super) placement: HeapPlacement,
    pub(super) passes: LoadedPasses,
    pub(super) uniforms: Buffer,
    pub(super) placed: Option<Placed>,
    /// Whether the heap is that of the previous plan.
    pub(super) shares_old_heap: bool,
}

/// What plans are made ready with.
#[derive(Clone)]
pub(super) struct PlanCompiler {
    pub(super) device: Device,
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
    pub(super) plan: Option<PlacedPlan>,
    pub(super) placed: Option<Placed>,
    /// Outputs that the host's images make the last passes draw, and in which format.
    pub(super) drawn: Vec<(String, TextureFormat)>,
}

impl PlanCompiler {
    /// Compiles the plan with this many threads. Its images keep their places in the heap where those still fit.
    pub(super) fn prepare(&self, plan: Arc<Plan>, before: &PreviousPlan, threads: usize) -> Result<Prepared, GpuError> {
        span!("afterimage::compile");
        if let Some(error) = &self.broken {
            return Err(error.clone());
        }
        if let Some(old) = before.plan.as_ref().filter(|old| old.plan.differs_in_uniforms_only(&plan)) {
            return Ok(Prepared::Numbers(plan, old.plan.clone()));
        }
        let PlacedPlan { plan, placement } = keep_places(plan, before);
        let passes = self.passes(&plan, before, threads)?;
        watched(&self.device, "the memory of the plan", || {
            let placed = self.place(&plan, &placement, before.placed.as_ref());
            let same = |old: &Placed| placed.as_ref().is_some_and(|placed| Arc::ptr_eq(&placed.heap, &old.heap));
            let shares_old_heap = before.placed.as_ref().is_some_and(same);
            let uniforms = self.uniforms(&plan)?;
            let compiled = CompiledPlan { plan, placement, passes, uniforms, placed, shares_old_heap };
            Ok(Prepared::Whole(Box::new(compiled)))
        })
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
        let orders = orders.flat_map(|(at, dispatch)| self.orders(plan, at, dispatch, &before.drawn));
        self.pipelines.build(&self.device, orders.collect(), threads)?;
        let finish = |(at, dispatch)| self.finish(plan, at, dispatch);
        let passes = dispatches.into_iter().enumerate().map(finish).collect();
        self.compiled.put(plan, &passes);
        Ok(passes)
    }

    /// The pipelines that a pass may need: the planned one, and the one for the host's image.
    fn orders<'a>(
        &self,
        plan: &'a Plan,
        index: usize,
        dispatch: &'a UncompiledDispatch,
        drawn: &[(String, TextureFormat)],
    ) -> impl Iterator<Item = Order<'a>> + use<'a> {
        let output = plan.outputs.iter().find(|output| Some(output.image) == dispatch.writes_image);
        let asked = drawn.iter().find(|(name, _)| output.is_some_and(|output| output.name == *name));
        let is_drawable = plan.passes[index].pass.kind.is_drawable();
        let extra = asked.filter(|_| is_drawable).map(|(_, format)| Some(*format));
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
        let by_hand = by_hand(&composed);
        LoadedPass { composed, workgroups, writes_image, by_hand, immediate, built }
    }

    fn uniforms(&self, plan: &Plan) -> Result<Buffer, GpuError> {
        let bytes = plan.uniform_buffer();
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        filled_buffer(&self.device, "uniforms", &bytes, usage)
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
    match before.plan.as_ref().filter(|_| before.placed.is_some()) {
        Some(old) => PlacedPlan::keeping(plan, old),
        None => PlacedPlan::new(plan),
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
pub(super) fn order<'a>(
    plan: &'a Plan,
    index: usize,
    (composed, immediate): (&'a Composed, bool),
    attachment: Option<TextureFormat>,
) -> Order<'a> {
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
    Order {
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
