//! Frames that a host announces: their plans are made and compiled before the first of them is recorded.

use std::sync::{Arc, Weak};

use afterimage_graph::check::GraphInput;
use afterimage_graph::image::Size;
use afterimage_plan::{HostInputs, Plan};
use wgpu::TextureFormat;

use super::bindings::{HostImage, Images};
use super::plan_state::{PlanState, UncachedPlan};
use crate::platform::Worker;

/// The most frames that can be announced: plans are cached for these at a few facts.
pub(super) const MAX_FRAMES: usize = 16;

/// A frame that a host will record, as far as plans depend on it: sizes and formats of its images.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExpectedFrame<'a> {
    /// The images of inputs, by their names.
    pub inputs: &'a [(&'a str, HostImage)],
    /// The optional inputs for which the frame has a block. Those that the pipeline needs are not listed.
    pub blocks: &'a [&'a str],
    /// The images of outputs, by their names.
    pub outputs: &'a [(&'a str, HostImage)],
    /// The sizes of the rectangles of inputs and outputs.
    pub rectangles: &'a [(&'a str, Size)],
    /// The inputs that have a factor.
    pub factors: &'a [&'a str],
}

/// The same, kept.
#[derive(Clone)]
pub(super) struct KeptFrame {
    inputs: Vec<(String, HostImage)>,
    blocks: Vec<String>,
    outputs: Vec<(String, HostImage)>,
    rectangles: Vec<(String, Size)>,
    factors: Vec<String>,
}

impl From<&ExpectedFrame<'_>> for KeptFrame {
    fn from(frame: &ExpectedFrame<'_>) -> Self {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let images = |images: &[(&str, HostImage)]| images.iter().map(|(name, of)| ((*name).to_owned(), *of)).collect();
        Self {
            inputs: images(frame.inputs),
            blocks: names(frame.blocks),
            outputs: images(frame.outputs),
            rectangles: frame.rectangles.iter().map(|(name, size)| ((*name).to_owned(), *size)).collect(),
            factors: names(frame.factors),
        }
    }
}

impl KeptFrame {
    /// The formats of outputs.
    pub(super) fn drawn(&self) -> Vec<(String, TextureFormat)> {
        self.outputs.iter().map(|(name, image)| (name.clone(), image.format)).collect()
    }
}

fn named<T: Copy>(all: &[(String, T)], name: &str) -> Option<T> {
    all.iter().find(|(known, _)| known == name).map(|(_, found)| *found)
}

impl Images for KeptFrame {
    fn input(&self, name: &str) -> Option<HostImage> {
        named(&self.inputs, name)
    }

    fn output(&self, name: &str) -> Option<HostImage> {
        named(&self.outputs, name)
    }

    fn first_output(&self) -> Option<&str> {
        self.outputs.first().map(|(name, _)| name.as_str())
    }

    fn rectangle_size(&self, name: &str) -> Option<Size> {
        named(&self.rectangles, name)
    }

    fn has_factor(&self, name: &str) -> bool {
        self.factors.iter().any(|known| known == name)
    }

    fn has_block(&self, input: &GraphInput) -> bool {
        input.block.is_some() && (!input.optional || self.blocks.contains(&input.name))
    }

    fn input_names(&self) -> Vec<&str> {
        self.inputs.iter().map(|(name, _)| name.as_str()).collect()
    }
}

/// A plan that is made and compiled, and the same for the cache if it was not there.
pub(super) type PreparedAhead = (Arc<Plan>, Option<UncachedPlan>);

/// The plan of a frame that is announced.
pub(super) struct AheadPlan {
    pub(super) frame: KeptFrame,
    /// The inputs of the plan that is being made.
    inputs: Option<HostInputs>,
    /// The version of the host's graph that it is made for.
    version: Option<u64>,
    /// The plan that is compiled for the formats of the frame.
    compiled: Weak<Plan>,
    state: PlanState<PreparedAhead>,
}

/// The plans of frames that a host has announced. One is made at a time.
#[derive(Default)]
pub(super) struct PlansAhead(Vec<AheadPlan>);

impl PlansAhead {
    pub(super) fn new(frames: impl IntoIterator<Item = KeptFrame>) -> Self {
        let plan =
            |frame| AheadPlan { frame, inputs: None, version: None, compiled: Weak::new(), state: PlanState::Ok };
        Self(frames.into_iter().map(plan).collect())
    }

    /// The same frames for another view or device.
    pub(super) fn without_plans(&self) -> Self {
        Self::new(self.0.iter().map(|plan| plan.frame.clone()))
    }

    /// Whether all plans are made for that version of the host's graph.
    pub(super) fn are_ready(&self, version: u64) -> bool {
        self.0.iter().all(|plan| plan.version == Some(version) && matches!(plan.state, PlanState::Ok))
    }

    /// The next plan that is not made for that version, unless one is being made.
    pub(super) fn next(&mut self, version: u64) -> Option<&mut AheadPlan> {
        if self.0.iter().any(|plan| matches!(plan.state, PlanState::Creating(_))) {
            return None;
        }
        self.0.iter_mut().find(|plan| plan.version != Some(version))
    }

    /// Takes the plan that is being made if it is finished, or if it is for these inputs.
    pub(super) fn take(
        &mut self,
        wanted: Option<&HostInputs>,
    ) -> Option<(&mut AheadPlan, super::plan_state::Creation<PreparedAhead>)> {
        self.0.iter_mut().find_map(|plan| {
            let is_wanted = wanted.is_some() && plan.inputs.as_ref() == wanted;
            let creation = if is_wanted { plan.state.take() } else { plan.state.take_finished() };
            creation.map(|creation| (plan, creation))
        })
    }
}

impl AheadPlan {
    /// Whether a plan is compiled for the frame.
    pub(super) fn has_compiled(&self, plan: &Arc<Plan>) -> bool {
        std::ptr::eq(self.compiled.as_ptr(), Arc::as_ptr(plan))
    }

    /// The plan for that version is made, or none can be made.
    pub(super) fn finish(&mut self, version: u64) {
        (self.version, self.inputs) = (Some(version), None);
    }

    /// Notes the plan that is compiled for the frame.
    pub(super) fn note_compiled(&mut self, plan: &Arc<Plan>) {
        self.compiled = Arc::downgrade(plan);
    }

    /// Starts to make the plan for these inputs and that version.
    pub(super) fn start(
        &mut self,
        inputs: HostInputs,
        version: u64,
        revision: super::plan_state::Revision,
        worker: Worker<Result<PreparedAhead, super::PostError>>,
    ) {
        (self.version, self.inputs) = (Some(version), Some(inputs));
        self.state.start(revision, worker);
    }
}
