//! Bind groups: a loaded plan with the images that the host gives for a frame.

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Subresource};
use afterimage_plan::codegen::{Slot, SlotKind};
use afterimage_plan::{PlanOutput, Stage};
use wgpu::{BindGroup, BindGroupEntry, BindingResource, TextureView};

use super::Executor;
use super::explicit_transitions::explicit_transitions;
use super::frame::Frame;
use super::host_images::{Formats, check_apart, check_encoding, check_input, check_names, check_output, must_be_drawn};
use super::loaded::{HostSet, ImageBinding, Loaded, Run};
use super::prepare::order;
use crate::GpuError;
use crate::layout::bound_slots;
use crate::pipelines::Built;
use crate::platform::{scoped, watched};
use crate::store::{Store, part_view};

/// How many choices of host images are remembered: the images of a few swap chains.
const MOST_SETS: usize = 16;

impl Executor {
    /// The bind groups for this frame's host images: remembered, or made.
    pub(super) fn host_set(&mut self, frame: &Frame<'_>) -> Result<usize, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        check_names(&loaded.plan, frame)?;
        let known = loaded.sets.iter().position(|set| same_views(&self.store, loaded, set, frame));
        let set = match known {
            Some(_) => None,
            None => Some(self.new_set(frame)?),
        };
        let loaded = self.loaded.as_mut().expect("it was there above");
        self.runs_made = set.as_ref().map_or(0, |set| set.made);
        match (known, set) {
            // The set used last is at the end.
            (Some(known), _) => loaded.sets[known..].rotate_left(1),
            (None, set) => {
                loaded.sets.drain(..(loaded.sets.len() + 1).saturating_sub(MOST_SETS));
                loaded.sets.extend(set);
            }
        }
        Ok(loaded.sets.len() - 1)
    }

    fn new_set(&mut self, frame: &Frame<'_>) -> Result<HostSet, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        let (device, what) = (&self.compiler.device, "the images of the host");
        let views = chosen_views(&self.store, loaded, frame)?;
        let drawn = drawn(device, &mut self.formats, (loaded, frame), &views)?;
        let set = match loaded.sets.last() {
            // A swap chain has new views in every frame: most of the last set is as good as new.
            Some(last) if last.drawn == drawn => {
                scoped(device, what, || self.make_set(loaded, views, &drawn, Some(last)))?
            }
            _ => watched(device, what, || self.make_set(loaded, views, &drawn, None))?,
        };
        let names = loaded.plan.outputs.iter().map(|output| &output.name).zip(drawn);
        let now: Vec<_> = names.filter_map(|(name, format)| Some((name, format?))).collect();
        if !now.iter().copied().eq(self.drawn.iter().map(|(name, format)| (name, *format))) {
            self.drawn = now.into_iter().map(|(name, format)| (name.clone(), format)).collect();
        }
        Ok(set)
    }

    /// The set for these views. What names only views that the last set has, too, is taken from there.
    fn make_set(
        &self,
        loaded: &Loaded,
        views: Vec<TextureView>,
        drawn: &Drawn,
        last: Option<&HostSet>,
    ) -> Result<HostSet, GpuError> {
        let mut made = 0;
        let mut run = |index: usize| match last {
            Some(last) if !names_new(loaded, index, (&last.views, &views)) => Ok(last.runs[index].clone()),
            _ => {
                made += 1;
                let built = last.map(|last| Ok(last.runs[index].built.clone()));
                let built = built.unwrap_or_else(|| self.built(loaded, index, drawn))?;
                Ok(self.make_run(loaded, index, built, &views))
            }
        };
        let runs = (0..loaded.passes.len()).map(&mut run).collect::<Result<Vec<_>, GpuError>>()?;
        let explicit_transitions = match last.map(|last| &last.explicit_transitions) {
            Some(known) if !known.has_host_views => known.clone(),
            _ => Arc::new(explicit_transitions(loaded, &self.store, &runs, &views)),
        };
        Ok(HostSet { views, drawn: drawn.to_vec(), runs, explicit_transitions, made })
    }

    /// The pipeline of a pass: the planned one, or the one that draws into the host's image.
    fn built(&self, loaded: &Loaded, index: usize, drawn: &Drawn) -> Result<Built, GpuError> {
        let pass = &loaded.passes[index];
        match pass.writes_image.and_then(|image| attachment_of_host(loaded, image, drawn)) {
            None => Ok(pass.built.clone()),
            Some(format) => self.drawing(loaded, index, format),
        }
    }

    fn make_run(&self, loaded: &Loaded, index: usize, built: Built, views: &[TextureView]) -> Run {
        let pass = &loaded.passes[index];
        let stage = built.pipeline.stage();
        let ring_indices = 0..loaded.ring_length;
        let groups = ring_indices
            .clone()
            .map(|ring_index| self.bind_group(loaded, index, stage, &built.layout, views, ring_index))
            .collect();
        let view = |image, ring_index| loaded.view(&self.store, image, views, ring_index);
        let drawing = loaded.plan.passes[index].pass.drawing();
        let targets = |ring_index| match (stage, pass.writes_image, drawing) {
            (Stage::Fragment, Some(image), _) => vec![view(image, ring_index).clone()],
            (Stage::Drawing, _, Some(drawing)) => {
                let part =
                    |part: Subresource| part_view(view(part.image, ring_index).texture(), part.level, part.layer);
                drawing.targets().map(part).collect()
            }
            _ => Vec::new(),
        };
        Run { built, groups, attachments: ring_indices.map(targets).collect() }
    }

    /// The pipeline that draws a pass's result into the host's image.
    fn drawing(&self, loaded: &Loaded, index: usize, format: wgpu::TextureFormat) -> Result<Built, GpuError> {
        let pipelines = &self.compiler.pipelines;
        let pass = &loaded.passes[index];
        let shader = (&pass.composed, pass.immediate);
        let order = order(&loaded.plan, index, shader, Some(format));
        let key = order.key.clone();
        pipelines.build(&self.compiler.device, vec![order], 1)?;
        Ok(pipelines.get(&key).expect("it was built above"))
    }

    fn bind_group(
        &self,
        loaded: &Loaded,
        index: usize,
        stage: Stage,
        layout: &wgpu::BindGroupLayout,
        views: &[TextureView],
        ring_index: u32,
    ) -> BindGroup {
        let pass = &loaded.passes[index];
        let region = |offset, bytes| {
            let size = std::num::NonZeroU64::new(bytes);
            BindingResource::Buffer(wgpu::BufferBinding { buffer: &loaded.uniforms, offset, size })
        };
        let uniform = &loaded.plan.passes[index].uniform;
        let frame = &self.frame_uniforms[usize::from(loaded.uses_uninitialized(index))];
        let whole = |image| loaded.view(&self.store, image, views, ring_index);
        let levels = level_views(bound_slots(&pass.composed, stage), &whole);
        let mut next_level = levels.iter();
        let mut resource = |kind| match kind {
            SlotKind::Level(_) => BindingResource::TextureView(next_level.next().expect("each has its view")),
            SlotKind::Frame => frame.as_entire_binding(),
            SlotKind::Block(block) => {
                let planned = loaded.plan.block(block);
                region(planned.offset, planned.block.bytes() as u64)
            }
            SlotKind::Params => region(uniform.offset, uniform.bytes.len() as u64),
            SlotKind::Extent => region(uniform.extent_offset, size_of_val(&uniform.extent) as u64),
            SlotKind::Sampler => BindingResource::Sampler(if pass.by_hand { &self.nearest } else { &self.linear }),
            SlotKind::Texture(image) | SlotKind::Storage(image) => BindingResource::TextureView(whole(image)),
            SlotKind::Buffer(buffer, _) => loaded.buffers[buffer.0 as usize].as_entire_binding(),
        };
        let entries: Vec<BindGroupEntry<'_>> = bound_slots(&pass.composed, stage)
            .map(|slot| BindGroupEntry { binding: slot.binding, resource: resource(slot.kind) })
            .collect();
        let device = &self.compiler.device;
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}

/// The views of single mip levels, in the order of their slots.
fn level_views<'s, 'v>(
    slots: impl Iterator<Item = &'s Slot>,
    whole: &dyn Fn(ImageId) -> &'v TextureView,
) -> Vec<TextureView> {
    let level = |slot: &Slot| match slot.kind {
        SlotKind::Level(part) => Some(part_view(whole(part.image).texture(), part.level, part.layer)),
        _ => None,
    };
    slots.filter_map(level).collect()
}

/// For each output the format in which the host's image for it is drawn; `None` for one that is stored to.
type Drawn = [Option<wgpu::TextureFormat>];

fn drawn(
    device: &wgpu::Device,
    formats: &mut Formats,
    (loaded, frame): (&Loaded, &Frame<'_>),
    views: &[TextureView],
) -> Result<Vec<Option<wgpu::TextureFormat>>, GpuError> {
    let outputs = loaded.plan.outputs.iter().zip(&views[loaded.plan.inputs.len()..]);
    let format = |(output, view): (&PlanOutput, &TextureView)| -> Result<_, GpuError> {
        let is_drawn = must_be_drawn(&loaded.plan, output.image, view.texture());
        let format = is_drawn
            .then(|| formats.of(device, (&output.name, view), frame.stated_format(&output.name)))
            .transpose()?;
        check_encoding(output, format)?;
        Ok(format)
    };
    outputs.map(format).collect()
}

/// Whether a pass names an image of the host whose view is another one now.
fn names_new(loaded: &Loaded, pass: usize, (last, views): (&[TextureView], &[TextureView])) -> bool {
    loaded.host_views[pass].iter().any(|view| last[*view] != views[*view])
}

/// The view of that name.
pub(super) fn named<'a>(views: &[(&str, &'a TextureView)], name: &str) -> Option<&'a TextureView> {
    views.iter().find(|(known, _)| *known == name).map(|(_, view)| *view)
}

/// Whether a set was made for exactly these host images.
fn same_views(store: &Store, loaded: &Loaded, set: &HostSet, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = set.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| named(frame.inputs, name) == Some(view);
    let same_output =
        |(output, view): (&PlanOutput, &TextureView)| output_view(store, loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}

/// Where an output goes: to the host's image, or to ours.
fn output_view<'a>(
    store: &'a Store,
    loaded: &Loaded,
    output: &PlanOutput,
    frame: &Frame<'a>,
) -> Option<&'a TextureView> {
    named(frame.outputs, &output.name).or_else(|| match &loaded.bindings[output.image.0 as usize] {
        ImageBinding::Output(_, key) => Some(&store.get(*key).view),
        _ => None,
    })
}

/// The views of all inputs, then of all outputs; ours where the host gives none.
fn chosen_views(store: &Store, loaded: &Loaded, frame: &Frame<'_>) -> Result<Vec<TextureView>, GpuError> {
    let plan = &loaded.plan;
    let mut views = Vec::with_capacity(plan.inputs.len() + plan.outputs.len());
    for (name, image) in &plan.inputs {
        let view = named(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
        check_input(plan, name, *image, view)?;
        views.push(view.clone());
    }
    for output in &plan.outputs {
        let view =
            output_view(store, loaded, output, frame).expect("the planner gives each output an image of its own");
        check_output(plan, &output.name, output.image, view)?;
        views.push(view.clone());
    }
    check_apart(plan, &views)?;
    Ok(views)
}

/// The attachment's format if the image is an output that is drawn into the host's.
fn attachment_of_host(loaded: &Loaded, image: ImageId, drawn: &Drawn) -> Option<wgpu::TextureFormat> {
    let ImageBinding::Output(index, _) = &loaded.bindings[image.0 as usize] else { return None };
    drawn[*index]
}
