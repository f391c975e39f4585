//! A plan that is ready to run, and what it runs on.

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Resource};
use afterimage_plan::codegen::Composed;
use afterimage_plan::{PlacedPlan, Plan, Stage};
use wgpu::{Buffer, TextureFormat, TextureView};

use super::explicit_transitions::ExplicitTransitions;
use super::host_set::Run;
use super::host_sets::HostSets;
use super::rectangle::{HeldRectangles, Rectangle};
use super::residency::{ImageBinding, Residency};
use crate::device::texture_format;
use crate::pipelines::Built;
use crate::timing::Timing;

pub(crate) struct Loaded {
    pub(super) plan: Arc<Plan>,
    pub(super) residency: Arc<Residency>,
    pub(super) passes: LoadedPasses,
    pub(super) uniforms: Buffer,
    /// What the uniforms hold of each host block.
    pub(super) blocks: Vec<Vec<u8>>,
    /// What the uniforms hold of rectangles.
    pub(super) rectangles: HeldRectangles,
    /// For each pass the images of the host that it names.
    pub(super) host_views: Vec<HostViews>,
    /// Whether each pass names images that are others in each frame of a ring.
    pub(super) in_rings: Vec<bool>,
    pub(super) zeroed: Vec<usize>,
    pub(super) persistent: Vec<usize>,
    /// The bind groups of passes that name no image of the host.
    pub(super) runs: Vec<Option<Arc<Run>>>,
    /// Passes that draw into the host's images, with the formats that those had when the plan was prepared, and the
    /// pipelines for them.
    pub(super) drawn: Vec<(usize, TextureFormat, Built)>,
    /// Whether the device was looked at when the plan was prepared in the background.
    pub(super) is_watched: bool,
    /// The explicit transitions for these formats.
    pub(super) explicit_transitions: Arc<ExplicitTransitions>,
    pub(super) sets: HostSets,
    pub(super) timing: Option<Timing>,
    /// The names of the passes, if they are marked.
    pub(super) labels: Option<Vec<String>>,
    /// Where the constants of the frame begin in their buffer, for most passes and for those whose memory begins.
    pub(super) frame_offsets: [u32; 2],
    /// Memory that no frame has written yet, while other memory is kept: the passes that use it reset in the first
    /// frame.
    pub(super) uninitialized: Vec<Resource>,
    /// Whether another plan has used the heap before.
    pub(super) shares_old_heap: bool,
}

/// A view of the host, and the name of its input or output.
pub(super) type NamedView = (String, TextureView);

/// The passes of one plan, which every executor that runs it shares.
pub(super) type LoadedPasses = Arc<[LoadedPass]>;

/// What one draw or dispatch needs.
pub(super) struct LoadedPass {
    pub(super) composed: Composed,
    pub(super) workgroups: [u32; 3],
    /// The first image that the pass writes.
    pub(super) writes_image: Option<ImageId>,
    pub(super) manual_filtering: bool,
    /// Whether it takes the frame constants from immediates.
    pub(super) immediate: bool,
    /// Whether it has the frame constants in its bind group, at a dynamic offset.
    pub(super) binds_frame: bool,
    /// Its pipeline, unless the host wants the result drawn in a format of its own.
    pub(super) built: Built,
}

/// The images of the host that a pass names, by their places among the host's views: inputs, then outputs.
pub(super) struct HostViews {
    pub(super) read: Vec<usize>,
    pub(super) written: Vec<usize>,
}

impl HostViews {
    pub(super) fn is_empty(&self) -> bool {
        self.read.is_empty() && self.written.is_empty()
    }

    /// Those that its bind group names.
    pub(super) fn in_group(&self, stage: Stage) -> impl Iterator<Item = &usize> {
        self.read.iter().chain(if stage == Stage::Compute { self.written.as_slice() } else { &[] })
    }

    /// Those that it draws into.
    pub(super) fn attached(&self, stage: Stage) -> &[usize] {
        if stage == Stage::Compute { &[] } else { &self.written }
    }
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
        match &self.residency.bindings[self.passes[pass].writes_image?.0 as usize] {
            ImageBinding::Output(output, _) => self.rectangles.outputs[*output],
            _ => None,
        }
    }
}

impl Loaded {
    /// The images that the host gave for the last frame, by the names of inputs and of outputs.
    pub(super) fn views_of_host(&self) -> (Vec<NamedView>, Vec<NamedView>) {
        let Some(set) = self.sets.last() else { return Default::default() };
        let (inputs, outputs) = set.views.split_at(self.plan.inputs.len());
        let inputs = self.plan.inputs.iter().zip(inputs).map(|((name, _), view)| (name.clone(), view.clone()));
        let is_ours = |image: ImageId, view: &TextureView| {
            let binding = &self.residency.bindings[image.0 as usize];
            matches!(binding, ImageBinding::Output(_, own) if own.view == *view)
        };
        let outputs = self.plan.outputs.iter().zip(outputs);
        let given = outputs.filter(|(output, view)| !is_ours(output.image, view));
        (inputs.collect(), given.map(|(output, view)| (output.name.clone(), view.clone())).collect())
    }

    /// The plan, and where its images lie.
    pub(super) fn placed_plan(&self) -> PlacedPlan {
        PlacedPlan { plan: self.plan.clone(), placement: self.residency.placement.clone() }
    }

    /// The dynamic offset in the bind group of a pass, if it has one.
    pub(super) fn frame_offset(&self, pass: usize) -> &[u32] {
        match self.passes[pass].binds_frame {
            true => std::slice::from_ref(&self.frame_offsets[usize::from(self.uses_uninitialized(pass))]),
            false => &[],
        }
    }

    /// Whether the pass uses memory that begins with this plan.
    pub(super) fn uses_uninitialized(&self, pass: usize) -> bool {
        let begins = |resource: &Resource| self.uninitialized.contains(resource);
        let pass = &self.plan.passes[pass].pass;
        !self.uninitialized.is_empty() && (pass.reads().iter().any(begins) || pass.writes().iter().any(begins))
    }
}

/// The format that the plan draws a pass's image in; `None` for a dispatch.
pub(super) fn planned_attachment(plan: &Plan, pass: usize, writes: Option<ImageId>) -> Option<TextureFormat> {
    let image = writes.filter(|_| plan.passes[pass].stage == Stage::Fragment)?;
    Some(texture_format(plan.image(image).desc.format))
}
