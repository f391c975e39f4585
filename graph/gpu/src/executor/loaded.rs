//! A plan that is ready to run, and what it runs on.

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Resource};
use afterimage_plan::codegen::Composed;
use afterimage_plan::{HeapPlacement, PlacedPlan, Plan, Stage};
use wgpu::{BindGroup, Buffer, TextureFormat, TextureView};

use super::rectangle::{HeldRectangles, Rectangle};
use crate::device::texture_format;
use crate::heap::Placed;
use crate::pipelines::Built;
use crate::store::{Store, TextureKey};
use crate::timing::Timing;

/// Where an image of the plan lies.
pub(super) enum ImageBinding {
    /// No pass mentions it.
    Unused,
    /// The host's image for this input.
    Input(usize),
    /// The host's image for this output, or else ours.
    Output(usize, TextureKey),
    /// Always the same texture.
    Fixed(TextureKey),
    /// A texture of a ring, so many frames behind the newest.
    Ring(Vec<TextureKey>, u32),
}

impl ImageBinding {
    /// The place among the host's views, if it is one of the host's.
    pub(super) fn host_view(&self, plan: &Plan) -> Option<usize> {
        match self {
            Self::Input(index) => Some(*index),
            Self::Output(index, _) => Some(plan.inputs.len() + index),
            Self::Unused | Self::Fixed(_) | Self::Ring(..) => None,
        }
    }
}

pub(super) struct Loaded {
    pub(super) plan: Arc<Plan>,
    /// Where the images of the plan lie.
    pub(super) placement: HeapPlacement,
    pub(super) passes: LoadedPasses,
    pub(super) uniforms: Buffer,
    /// What the uniforms hold of each host block.
    pub(super) blocks: Vec<Vec<u8>>,
    /// What the uniforms hold of rectangles.
    pub(super) rectangles: HeldRectangles,
    pub(super) bindings: Vec<ImageBinding>,
    /// For each pass the places of the images that it names among the host's views: inputs, then outputs.
    pub(super) host_views: Vec<Vec<usize>>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) zeroed: Vec<usize>,
    pub(super) persistent: Vec<usize>,
    pub(super) ring_length: u32,
    pub(super) sets: Vec<HostSet>,
    pub(super) timing: Option<Timing>,
    /// The names of the passes, if they are marked.
    pub(super) labels: Option<Vec<String>>,
    /// The images in the heap, if the device can place them.
    pub(super) placed: Option<Placed>,
    /// Whether a pass has the frame in its bind group.
    pub(super) binds_frame: bool,
    /// The textures of the heap.
    pub(super) heap_textures: Vec<TextureKey>,
    /// Memory that no frame has written yet, while other memory is kept: the passes that use it reset in the first
    /// frame.
    pub(super) uninitialized: Vec<Resource>,
    /// Whether another plan has used the heap before.
    pub(super) shares_old_heap: bool,
}

/// The passes of one plan, which every executor that runs it shares.
pub(super) type LoadedPasses = Arc<[LoadedPass]>;

/// What one draw or dispatch needs.
pub(super) struct LoadedPass {
    pub(super) composed: Composed,
    pub(super) workgroups: [u32; 3],
    /// The first image that the pass writes.
    pub(super) writes_image: Option<ImageId>,
    pub(super) by_hand: bool,
    /// Whether it takes the frame constants from immediates.
    pub(super) immediate: bool,
    /// Its pipeline, unless the host wants the result drawn in a format of its own.
    pub(super) built: Built,
}

/// The bind groups for one choice of host images.
pub(super) struct HostSet {
    pub(super) views: Vec<TextureView>,
    /// For each output the format in which it is drawn, if it is.
    pub(super) drawn: Vec<Option<TextureFormat>>,
    /// How many runs are its own, and not those of the set before.
    pub(super) made: usize,
    pub(super) runs: Vec<Run>,
    pub(super) explicit_transitions: Arc<ExplicitTransitions>,
}

/// What must be brought into its state before batches.
pub(super) struct ExplicitTransitions {
    /// For each pass that opens a batch, for each ring index.
    pub(super) of_passes: Vec<Vec<Vec<ExplicitTransition>>>,
    /// Whether images of the host are among them.
    pub(super) has_host_views: bool,
}

/// A texture and the state that a batch wants it in.
pub(super) struct ExplicitTransition {
    pub(super) view: TextureView,
    pub(super) state: wgpu::TextureUses,
}

impl Loaded {
    /// The uniforms hold zeros again where host blocks and rectangles were.
    pub(super) fn forget_blocks(&mut self) {
        self.blocks.iter_mut().for_each(|held| held.fill(0));
        self.forget_rectangles();
    }
}

impl Loaded {
    /// The uniforms may hold zeros again where rectangles were.
    pub(super) fn forget_rectangles(&mut self) {
        self.rectangles.forget();
    }

    /// The name of a pass, if passes are marked.
    pub(super) fn label(&self, pass: usize) -> Option<&str> {
        self.labels.as_ref().map(|labels| labels[pass].as_str())
    }

    /// The rectangle that a pass draws into, if its output has one.
    pub(super) fn drawn_rectangle(&self, pass: usize) -> Option<Rectangle> {
        match &self.bindings[self.passes[pass].writes_image?.0 as usize] {
            ImageBinding::Output(output, _) => self.rectangles.outputs[*output],
            _ => None,
        }
    }
}

impl HostSet {
    /// The explicit transitions before a pass, if it has some.
    pub(super) fn transitions_before(&self, pass: usize, ring_index: usize) -> Option<&[ExplicitTransition]> {
        self.explicit_transitions.of_passes[pass].get(ring_index).map(Vec::as_slice)
    }
}

#[derive(Clone)]
pub(super) struct Run {
    pub(super) built: Built,
    /// For each ring index.
    pub(super) groups: Vec<BindGroup>,
    /// The attachments of a draw, for each ring index: colors, then depth.
    pub(super) attachments: Vec<Vec<TextureView>>,
}

impl Loaded {
    /// The view of an image in that ring index; `views` are those of the host.
    pub(super) fn view<'a>(
        &'a self,
        store: &'a Store,
        image: ImageId,
        views: &'a [TextureView],
        ring_index: u32,
    ) -> &'a TextureView {
        match &self.bindings[image.0 as usize] {
            ImageBinding::Input(_) | ImageBinding::Output(..) => {
                &views[self.host_view(image).expect("it is the host's")]
            }
            ImageBinding::Fixed(key) => &store.get(*key).view,
            ImageBinding::Ring(keys, behind) => &store.get(keys[ring_place(keys.len(), ring_index, *behind)]).view,
            ImageBinding::Unused => panic!("image {image:?} is bound but no pass mentions it"),
        }
    }

    /// The place of an image among the host's views, if it is one of the host's: inputs, then outputs.
    pub(super) fn host_view(&self, image: ImageId) -> Option<usize> {
        self.bindings[image.0 as usize].host_view(&self.plan)
    }

    /// The plan, and where its images lie.
    pub(super) fn placed_plan(&self) -> PlacedPlan {
        PlacedPlan { plan: self.plan.clone(), placement: self.placement.clone() }
    }

    /// Whether the pass uses memory that begins with this plan.
    pub(super) fn uses_uninitialized(&self, pass: usize) -> bool {
        let begins = |resource: &Resource| self.uninitialized.contains(resource);
        let pass = &self.plan.passes[pass].pass;
        !self.uninitialized.is_empty() && (pass.reads().iter().any(begins) || pass.writes().iter().any(begins))
    }
}

/// The place in a ring of that many textures of the one that is so many frames behind the frame.
pub(super) fn ring_place(length: usize, frame: u32, behind: u32) -> usize {
    let length = length as u32;
    ((frame % length + length - behind % length) % length) as usize
}

/// The format that the plan draws a pass's image in; `None` for a dispatch.
pub(super) fn planned_attachment(plan: &Plan, pass: usize, writes: Option<ImageId>) -> Option<TextureFormat> {
    let image = writes.filter(|_| plan.passes[pass].stage == Stage::Fragment)?;
    Some(texture_format(plan.image(image).desc.format))
}
