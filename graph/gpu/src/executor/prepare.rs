//! Everything of a plan that takes long, made on any thread while another plan runs: shaders, pipelines, and the images of its heap.

use std::sync::Arc;
use std::thread::JoinHandle;

use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{ImageId, Pass, Resource, Work};
use afterimage_plan::codegen::{Composed, SlotKind, workgroups};
use afterimage_plan::{Alias, Plan, Stage};
use wgpu::util::DeviceExt as _;
use wgpu::{Buffer, BufferUsages, Device, TextureFormat};

use super::frame_constants::{self, take_immediates};
use super::loaded::{LoadedPass, planned_attachment};
use super::uniforms::{differs_in_uniforms_only, regions, uniform_bytes};
use crate::GpuError;
use crate::heap::Placed;
use crate::layout::{bind_group_layout, by_hand};
use crate::pipelines::{Order, PipelineKey, Pipelines, watched};

/// A plan that is being made ready on a thread of its own, from [`Executor::prepare`](crate::Executor::prepare). Dropped, it is forgotten;
/// what it has compiled until then is not lost.
pub struct Preparation {
    pub(super) worker: JoinHandle<Result<Prepared, GpuError>>,
}

impl Preparation {
    /// Whether [`Executor::swap`](crate::Executor::swap) would not have to wait, be it for a plan or for an error.
    pub fn is_ready(&self) -> bool {
        self.worker.is_finished()
    }
}

/// A plan that can be swapped in.
pub(super) enum Prepared {
    /// The plan differs from the running one (the second) only in numbers.
    Numbers(Arc<Plan>, Arc<Plan>),
    Whole(Box<CompiledPlan>),
}

/// What a plan needs that no other plan has.
pub(super) struct CompiledPlan {
    pub(super) plan: Arc<Plan>,
    pub(super) passes: Vec<LoadedPass>,
    pub(super) uniforms: Buffer,
    /// Where the uniform of each pass begins in the buffer, and its bytes.
    pub(super) regions: Vec<(u64, u64)>,
    pub(super) placed: Option<Placed>,
    /// Whether the heap is that of the plan before.
    pub(super) moved_in: bool,
}

/// What plans are made ready with.
#[derive(Clone)]
pub(super) struct PlanCompiler {
    pub(super) device: Device,
    pub(super) pipelines: Arc<Pipelines>,
    /// Whether passes are told of the frame by immediates.
    pub(super) immediates: bool,
}

/// What the plan that runs has to offer.
#[derive(Clone, Default)]
pub(super) struct PreviousPlan {
    pub(super) plan: Option<Arc<Plan>>,
    pub(super) placed: Option<Placed>,
    /// Outputs that the host's images make the last passes draw, and in which format.
    pub(super) drawn: Vec<(String, TextureFormat)>,
}

impl PlanCompiler {
    /// Makes the plan ready with so many threads. Its images keep their places in the heap where those still fit.
    pub(super) fn prepare(&self, plan: Arc<Plan>, before: &PreviousPlan, threads: usize) -> Result<Prepared, GpuError> {
        let plan = keep_places(plan, before);
        if let Some(old) = before.plan.as_ref().filter(|old| differs_in_uniforms_only(old, &plan)) {
            return Ok(Prepared::Numbers(plan, old.clone()));
        }
        let drafts = (0..plan.recording.passes.len())
            .map(|at| UncompiledDispatch::new(&plan, at, self.immediates))
            .collect::<Result<Vec<_>, _>>()?;
        let orders = drafts.iter().enumerate().flat_map(|(at, draft)| self.orders(&plan, at, draft, &before.drawn));
        self.pipelines.build(&self.device, orders.collect(), threads)?;
        let passes = drafts.into_iter().enumerate().map(|(at, draft)| self.finish(&plan, at, draft)).collect();
        watched(&self.device, "the memory of the plan", || {
            let placed = self.place(&plan, before.placed.as_ref());
            let same = |old: &Placed| placed.as_ref().is_some_and(|placed| Arc::ptr_eq(&placed.heap, &old.heap));
            let moved_in = before.placed.as_ref().is_some_and(same);
            let (uniforms, regions) = (self.uniforms(&plan), regions(&plan));
            Ok(Prepared::Whole(Box::new(CompiledPlan { plan, passes, uniforms, regions, placed, moved_in })))
        })
    }

    /// The pipelines that a pass may need: the planned one, and the one for the host's image.
    fn orders<'a>(
        &self,
        plan: &'a Plan,
        index: usize,
        draft: &'a UncompiledDispatch,
        drawn: &[(String, TextureFormat)],
    ) -> impl Iterator<Item = Order<'a>> + use<'a> {
        let output = plan.outputs.iter().find(|output| Some(output.image) == draft.writes_image);
        let asked = drawn.iter().find(|(name, _)| output.is_some_and(|output| output.name == *name));
        let is_function = matches!(plan.recording.passes[index].work, Work::Steps { .. });
        let extra = asked.filter(|_| is_function).map(|(_, format)| Some(*format));
        let planned = planned_attachment(plan, index, draft.writes_image);
        let attachments: Vec<_> = std::iter::once(planned).chain(extra).collect();
        let device = self.device.clone();
        attachments
            .into_iter()
            .map(move |attachment| order(&device, plan, index, (&draft.composed, draft.immediate), attachment))
    }

    fn finish(&self, plan: &Plan, index: usize, draft: UncompiledDispatch) -> LoadedPass {
        let UncompiledDispatch { composed, workgroups, writes_image, immediate } = draft;
        let attachment = planned_attachment(plan, index, writes_image);
        let key = order(&self.device, plan, index, (&composed, immediate), attachment).key;
        let built = self.pipelines.get(&key).expect("every planned pipeline was built");
        let by_hand = by_hand(&composed);
        LoadedPass { composed, workgroups, writes_image, by_hand, immediate, built }
    }

    fn uniforms(&self, plan: &Plan) -> Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("uniforms"),
            contents: &uniform_bytes(plan),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        })
    }

    /// The plan's transient images in one heap, where the plan and the backend allow it.
    fn place(&self, plan: &Plan, old: Option<&Placed>) -> Option<Placed> {
        let images = plan.recording.images.iter().zip(&plan.memory.offset_of);
        let places: Vec<(u64, ImageDesc, &str)> =
            images.filter_map(|(image, offset)| Some(((*offset)?, image.desc, image.label.as_str()))).collect();
        if plan.options.alias != Alias::Placed || places.is_empty() {
            return None;
        }
        Placed::new(&self.device, plan.memory.heap, &places, old)
    }
}

fn keep_places(plan: Arc<Plan>, before: &PreviousPlan) -> Arc<Plan> {
    let Some((old, _)) = before.plan.as_ref().zip(before.placed.as_ref()) else { return plan };
    let mut kept = (*plan).clone();
    if kept.place_keeping(old) { Arc::new(kept) } else { plan }
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
        let mut composed = plan.compose(index).map_err(GpuError::Shader)?;
        let writes_image = written(&plan.recording.passes[index]);
        let immediate = immediates && take_immediates(&mut composed);
        Ok(Self {
            composed,
            workgroups: workgroups(&plan.recording, &plan.recording.passes[index]),
            writes_image,
            immediate,
        })
    }
}

/// The first image that a pass writes.
pub(super) fn written(pass: &Pass) -> Option<ImageId> {
    pass.writes().into_iter().find_map(|resource| match resource {
        Resource::Image(image) => Some(image),
        Resource::Buffer(_) => None,
    })
}

/// What must be compiled for a pass, whether or not it takes the frame from immediates; drawn if there is an attachment.
pub(super) fn order<'a>(
    device: &Device,
    plan: &'a Plan,
    index: usize,
    (composed, immediate): (&'a Composed, bool),
    attachment: Option<TextureFormat>,
) -> Order<'a> {
    let stage = if attachment.is_some() { Stage::Fragment } else { Stage::Compute };
    let pass = &plan.recording.passes[index];
    let constants = pass.constants().iter().map(|(name, value)| (*name, value.to_bits())).collect();
    let sample_modes = composed.slots.iter().map(|slot| match slot.kind {
        SlotKind::Texture(image) => format!("{:?}", plan.sample_modes[image.0 as usize]),
        _ => String::new(),
    });
    let layout: Vec<String> = sample_modes.collect();
    Order {
        key: PipelineKey {
            source: composed.source.clone(),
            entry: composed.compute.clone(),
            constants,
            attachment,
            layout: layout.join(","),
            checked: plan.options.bounds_checks || !composed.unchecked,
        },
        composed,
        stage,
        layout: bind_group_layout(device, plan, composed, stage),
        immediate_bytes: if immediate { frame_constants::BYTES } else { 0 },
        label: pass.label.clone(),
        // Tilings write every texel of a tile that they read; whole kernels are their authors' own.
        zero_workgroup_memory: !composed.unchecked && matches!(pass.work, Work::Entry(_) | Work::Cells(_)),
    }
}
