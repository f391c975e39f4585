//! A loaded plan: its pipelines, memory and bind groups.

pub(crate) mod bind_group_cache;
pub(crate) mod bind_groups;
pub(crate) mod due_passes;
pub(crate) mod explicit_transitions;
mod inspection;
pub(crate) mod previous;
pub(crate) mod redraw;
pub(crate) mod residency;
pub(crate) mod uniforms;

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Resource};
use afterimage_plan::codegen::Composed;
use afterimage_plan::{PlacedPlan, Plan, Stage};
use wgpu::{TextureFormat, TextureView};

use crate::executor::loaded::bind_group_cache::BindGroupCache;
use crate::executor::loaded::bind_groups::BoundPass;
use crate::executor::loaded::due_passes::{DuePasses, WrittenBuffer};
use crate::executor::loaded::explicit_transitions::ExplicitTransitions;
use crate::executor::loaded::redraw::Redraw;
use crate::executor::loaded::residency::{ImageBinding, Residency};
use crate::executor::loaded::uniforms::Uniforms;
use crate::executor::rectangle::Rectangle;
use crate::frame_constants::FrameConstants;
use crate::pipelines::Built;
use crate::texture_format::texture_format;
use crate::timing::Timestamps;

/// The plan in use with its pipelines, memory and bind groups.
pub struct LoadedPlan {
    pub(crate) plan: Arc<Plan>,
    pub(crate) residency: Arc<Residency>,
    pub(crate) passes: LoadedPasses,
    pub(crate) uniforms: Uniforms,
    pub(crate) due: DuePasses,
    /// The part of the host's image that each output went into in the last frame, unless that was all of it.
    pub(crate) scissors: Vec<Option<Rectangle>>,
    /// The host images of each pass.
    pub(crate) host_views: Vec<HostViews>,
    /// True if each pass binds a history image, which rotates every frame.
    pub(crate) in_rings: Vec<bool>,
    pub(crate) zeroed: Vec<WrittenBuffer>,
    pub(crate) persistent: Vec<WrittenBuffer>,
    pub(crate) redraw: Option<Redraw>,
    /// The passes that bind no image of the host.
    pub(crate) bound: Vec<Option<Arc<BoundPass>>>,
    /// Passes that draw into the host's images, with the formats that those had when the plan was prepared, and the
    /// pipelines for them.
    pub(crate) drawn: Vec<(usize, TextureFormat, Built)>,
    /// True if the device was checked for errors when the plan was prepared in the background.
    pub(crate) is_watched: bool,
    /// The explicit transitions for these formats.
    pub(crate) explicit_transitions: Arc<ExplicitTransitions>,
    pub(crate) bind_groups: BindGroupCache,
    pub(crate) timing: Option<Timestamps>,
    /// The names of the passes, if they are labeled.
    pub(crate) labels: Option<Vec<String>>,
    /// Offsets of the frame constants in their buffer: for most passes, and for those that use uninitialized memory.
    pub(crate) frame_offsets: [u32; 2],
    /// Memory that no frame has written yet: the passes that use it reset in the first frame.
    pub(crate) uninitialized: Vec<Resource>,
    /// True if the previous plan used the same heap.
    pub(crate) shares_old_heap: bool,
    /// The number of the last frame, which selects the textures of histories.
    pub(crate) last_index: u32,
}

/// A view of the host, and the name of its input or output.
pub(crate) type NamedView = (String, TextureView);

/// The passes of one plan, which every executor that runs it shares.
pub(crate) type LoadedPasses = Arc<[LoadedPass]>;

pub(crate) struct LoadedPass {
    pub(crate) composed: Composed,
    pub(crate) workgroups: [u32; 3],
    /// The first image that the pass writes.
    pub(crate) writes_image: Option<ImageId>,
    /// True if it takes the frame constants from immediates.
    pub(crate) immediate: bool,
    /// True if it has the frame constants in its bind group, at a dynamic offset.
    pub(crate) binds_frame: bool,
    /// Its pipeline, unless the result is drawn into the host's image in another format.
    pub(crate) built: Built,
}

/// The host images of a pass, by their index among the host's views: inputs, then outputs.
pub(crate) struct HostViews {
    pub(crate) read: Vec<usize>,
    pub(crate) written: Vec<usize>,
}

impl HostViews {
    pub(crate) fn is_empty(&self) -> bool {
        self.read.is_empty() && self.written.is_empty()
    }

    /// Those in its bind group.
    pub(crate) fn in_group(&self, stage: Stage) -> impl Iterator<Item = &usize> {
        self.read.iter().chain(if stage == Stage::Compute { self.written.as_slice() } else { &[] })
    }

    /// Those that are attachments.
    pub(crate) fn attached(&self, stage: Stage) -> &[usize] {
        if stage == Stage::Compute { &[] } else { &self.written }
    }
}

impl LoadedPlan {
    /// Recorded commands may never run: the next frame records everything that later ones depend on, except histories
    /// and state.
    pub(crate) fn invalidate(&mut self) {
        self.uniforms.invalidate();
        self.due.invalidate();
        self.shares_old_heap |= self.residency.placed.is_some();
        self.set_last_constants(None);
    }

    /// Changes bytes of the uniforms from the next frame on. Blocks and rectangles between them are those of that
    /// frame.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn set_uniforms(&mut self, offset: u64, bytes: &[u8]) {
        self.uniforms.set(offset, bytes);
    }

    /// Has the next frame run all passes that run after a change of their uniforms.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn force_on_change(&mut self) {
        self.due.force_on_change(&self.plan);
        self.set_last_constants(None);
    }

    /// The constants of the last frame, if it can be drawn again from the state before it.
    pub(crate) fn last_constants(&self) -> Option<FrameConstants> {
        self.redraw.as_ref()?.constants
    }

    /// Sets the constants of the last frame; `None` if it cannot be drawn again.
    pub(crate) fn set_last_constants(&mut self, constants: Option<FrameConstants>) {
        if let Some(redraw) = &mut self.redraw {
            redraw.constants = constants;
        }
    }

    /// Drops the bind groups of frames that write an output to a texture of ours.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn drop_bind_groups_of_own_outputs(&mut self) {
        let Self { plan, residency, bind_groups, .. } = self;
        let ours: Vec<&TextureView> =
            plan.outputs.iter().filter_map(|output| residency.own_output(output.image)).collect();
        bind_groups.retain(|groups| !groups.views[plan.inputs.len()..].iter().any(|view| ours.contains(&view)));
    }

    /// True if later frames depend on the next one, besides histories, state and values of parameters. A cut, as the
    /// first frame after a dropped one is, copies all values.
    pub(crate) fn is_needed_later(&self) -> bool {
        self.due.renews_results(&self.plan, self.uniforms.bytes()) || self.shares_old_heap
    }

    /// Chooses the passes of a frame of that number, after one of the number `before`. Without one, all of them run.
    pub(crate) fn choose_passes(&mut self, number: u32, before: Option<u32>) {
        self.due.choose(&self.plan, self.uniforms.bytes(), number, before);
    }

    /// Chooses the passes that depend on changed values, to draw the last frame again; `false` if all of them must run.
    pub(crate) fn choose_dependents(&mut self) -> bool {
        self.due.choose_dependents(&self.plan, self.uniforms.bytes())
    }

    /// The name of a pass, if passes are labeled.
    pub(crate) fn label(&self, pass: usize) -> Option<&str> {
        self.labels.as_ref().map(|labels| labels[pass].as_str())
    }

    /// The part of its output that a pass draws into, unless that is all of it.
    pub(crate) fn scissor(&self, pass: usize) -> Option<Rectangle> {
        match &self.residency.bindings[self.passes[pass].writes_image?.0 as usize] {
            ImageBinding::Output(output, _) => self.scissors[*output],
            _ => None,
        }
    }

    /// The host's images of the last frame, by the names of inputs and of outputs.
    pub(crate) fn views_of_host(&self) -> (Vec<NamedView>, Vec<NamedView>) {
        let Some(groups) = self.bind_groups.last() else { return Default::default() };
        let (inputs, outputs) = groups.views.split_at(self.plan.inputs.len());
        let inputs = self.plan.inputs.iter().zip(inputs).map(|((name, _), view)| (name.clone(), view.clone()));
        let outputs = self.plan.outputs.iter().zip(outputs);
        let given = outputs.filter(|(output, view)| self.residency.own_output(output.image) != Some(*view));
        (inputs.collect(), given.map(|(output, view)| (output.name.clone(), view.clone())).collect())
    }

    /// The plan, and where its images lie.
    pub fn placed_plan(&self) -> PlacedPlan {
        PlacedPlan { plan: self.plan.clone(), placement: self.residency.placement.clone() }
    }

    /// The dynamic offset in the bind group of a pass, if it has one.
    pub(crate) fn frame_offset(&self, pass: usize) -> &[u32] {
        match self.passes[pass].binds_frame {
            true => std::slice::from_ref(&self.frame_offsets[usize::from(self.uses_uninitialized(pass))]),
            false => &[],
        }
    }

    /// True if the pass uses memory that no frame has written yet.
    pub(crate) fn uses_uninitialized(&self, pass: usize) -> bool {
        let begins = |resource: &Resource| self.uninitialized.contains(resource);
        let pass = &self.plan.passes[pass].pass;
        !self.uninitialized.is_empty() && (pass.reads().iter().any(begins) || pass.writes().iter().any(begins))
    }
}

/// The format of the attachment of a planned draw; `None` for a dispatch.
pub(crate) fn planned_attachment(plan: &Plan, pass: usize, writes: Option<ImageId>) -> Option<TextureFormat> {
    let image = writes.filter(|_| plan.passes[pass].stage == Stage::Fragment)?;
    Some(texture_format(plan.image(image).desc.format))
}
