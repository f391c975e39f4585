//! A pipeline that renders on the viewer's device.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::{Control, PassTimes};
use afterimage_gpu::wgpu::{self, TextureView};
use afterimage_gpu::{Frame, FrameKind, Gpu};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::ColorState;
use afterimage_graph::node::BlockData;
use afterimage_graph::value::Value;
use afterimage_plan::{Options, Plan};

use super::{Changes, FrameImages, Target};
use crate::Problem;

/// The time of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the start.
    pub time: f64,
    /// Seconds since the frame before.
    pub dt: f64,
    /// Relation to the frame before.
    pub kind: FrameKind,
}

/// Planner options for a purpose of the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanPreset {
    /// The options of a host.
    Show,
    /// Every image of every node is stored in memory of its own, and can be read after the frame.
    Inspect,
    /// As `Inspect`, with 32-bit images.
    Reference,
    /// Counts the faults of kinds in folders.
    CountFaults,
}

impl PlanPreset {
    fn options(self) -> Options {
        match self {
            Self::Show => Options::default(),
            Self::CountFaults => Options { count_faults: true, ..Options::default() },
            Self::Inspect | Self::Reference => {
                Options { fuse: false, repeatable: true, exact: self == Self::Reference, ..Options::default() }
            }
        }
    }
}

/// A pipeline that renders on the viewer's device, with the parameters that were set.
pub struct PipelineInstance {
    post: Post,
    /// The parameters that were set.
    controls: Vec<Control>,
    /// True if its passes are timed, false if the device has no timestamps inside passes; `None` before the first plan.
    is_timed: Option<bool>,
}

impl PipelineInstance {
    pub fn new(gpu: &Gpu, graph: Graph, facts: Facts, preset: PlanPreset) -> Self {
        let mut post = Post::with_executor(gpu.executor(), graph);
        // A paused frame is repeated with each value that is changed.
        post.set_options(gpu.options_to_repeat(preset.options()));
        post.set_facts(facts);
        Self { post, controls: Vec::new(), is_timed: None }
    }

    pub fn post(&mut self) -> &mut Post {
        &mut self.post
    }

    /// The graph at its present values.
    pub fn graph(&self) -> &Graph {
        self.post.graph()
    }

    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.post.plan()
    }

    /// Replaces the graph; handles and values stay.
    pub fn change(&mut self, graph: Graph) {
        // A number that was changed in the text is likely to be changed again, so its next change needs no plan.
        if let Some(name) = self.tuned(&graph) {
            let _ = self.post.control(&name);
        }
        self.post.change(graph);
    }

    /// The parameter whose value is the only difference of another graph.
    fn tuned(&self, graph: &Graph) -> Option<String> {
        let present = self.post.graph();
        if !present.has_structure_of(graph) {
            return None;
        }
        let mut differing = graph.parameters().filter(|id| present.value(*id) != graph.value(*id));
        let only = differing.next().filter(|_| differing.next().is_none())?;
        Some(graph.parameter_name(only))
    }

    /// Sets a parameter. While the graph has none of that name, the value waits for one that has.
    ///
    /// # Errors
    /// The node refuses it.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), Problem> {
        let control = self.post.control(name)?;
        if !self.controls.contains(&control) {
            self.controls.push(control);
        }
        Ok(self.post.set_value(control, value.clone())?)
    }

    /// Sets the parameters that the user has changed.
    pub(super) fn set_changes(&mut self, changes: &Changes) {
        for (target, value) in changes.iter() {
            if let Target::Parameter(name) = target {
                // Another tier, pipeline or text may have no such parameter, and keeps its own values.
                let _ = self.set(name, value);
            }
        }
    }

    /// Reverts to the values in the graph.
    pub fn forget_values(&mut self) {
        for control in std::mem::take(&mut self.controls) {
            // The value of the graph itself is accepted.
            let _ = self.post.unset(control);
        }
    }

    /// Recreates all GPU resources on a new device.
    pub fn rebuild(&mut self, gpu: &Gpu) {
        self.post.rebuild(gpu);
        self.is_timed = None;
    }

    /// True while a new plan is being made.
    pub fn is_changing(&self) -> bool {
        self.post.is_changing()
    }

    /// Records a frame.
    ///
    /// # Errors
    /// The images do not suit the pipeline, or the device fails.
    pub fn frame(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        images: &FrameImages,
        moment: Moment,
    ) -> Result<(), Problem> {
        if self.is_timed.is_none() && self.post.plan().is_some() {
            self.is_timed = Some(self.post.time_passes()?);
        }
        let inputs: Vec<(&str, &TextureView)> =
            images.images.iter().map(|(name, view)| (name.as_str(), view)).collect();
        let blocks: Vec<(&str, &BlockData)> = images.blocks.iter().map(|(name, data)| (name.as_str(), data)).collect();
        let Moment { time, dt, kind } = moment;
        let dt = dt as f32;
        let frame = Frame { inputs: &inputs, blocks: &blocks, time, dt, kind, ..Frame::default() };
        Ok(self.post.encode(encoder, &frame)?)
    }

    /// The name of the output that is shown: the first that is encoded, or else the first.
    pub fn output(&self) -> Option<String> {
        let outputs = &self.post.plan()?.outputs;
        let shown = outputs.iter().find(|output| output.state == ColorState::Encoded).or(outputs.first())?;
        Some(shown.name.clone())
    }

    /// The color state of that output.
    pub fn output_state(&self) -> Option<ColorState> {
        let name = self.output()?;
        Some(self.post.plan()?.output(Some(&name))?.state)
    }

    /// The texture of that output.
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        self.post.output(&self.output()?).ok()
    }

    /// The texture of an output.
    pub(super) fn output_texture(&self, name: &str) -> &wgpu::Texture {
        self.post.output(name).expect("the plan has the output")
    }

    pub(super) fn facts(&self) -> &Facts {
        self.post.facts()
    }

    /// The texture of an image of the plan.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        self.post.image(name)
    }

    /// True if the device has no timestamps inside passes.
    pub fn lacks_timestamps(&self) -> bool {
        self.is_timed == Some(false)
    }

    /// The latest times of passes; `None` on devices without timestamps, and before a whole frame was timed.
    pub fn pass_times(&self) -> Option<&PassTimes> {
        self.post.pass_times()
    }
}
