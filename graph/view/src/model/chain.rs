//! A pipeline on the viewer's device, with the values that were set.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::{Control, PassTimes};
use afterimage_gpu::wgpu::{self, TextureView};
use afterimage_gpu::{Frame, FrameKind, Gpu};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::ColorState;
use afterimage_graph::node::BlockData;
use afterimage_graph::value::Value;
use afterimage_plan::{Options, Plan, When};

use super::frame_images::FrameImages;
use crate::Problem;

/// Where a frame is in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the start.
    pub time: f64,
    /// Seconds since the frame before.
    pub dt: f64,
    /// How its frame follows the one before.
    pub kind: FrameKind,
}

/// A pipeline on the viewer's device.
pub struct Chain {
    post: Post,
    /// The parameters that were set.
    controls: Vec<Control>,
    is_timed: bool,
}

/// How the graph is planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// As a host would plan it.
    Show,
    /// Every image of every node is stored in memory of its own, so that it can be looked at after the frame.
    Inspect,
    /// The same with 32 bits: the reference.
    Reference,
    /// Functions of kinds in folders are called once more, to count what they do wrong.
    CountFaults,
}

impl Purpose {
    fn options(self) -> Options {
        match self {
            Self::Show => Options::default(),
            Self::CountFaults => Options { probes: true, ..Options::default() },
            Self::Inspect | Self::Reference => Options {
                fuse: false,
                row_downsample: When::Never,
                repeatable: true,
                exact: self == Self::Reference,
                ..Options::default()
            },
        }
    }
}

impl Chain {
    /// A graph on a device.
    pub fn new(gpu: &Gpu, graph: Graph, purpose: Purpose) -> Self {
        let mut post = Post::with_executor(gpu.executor(), graph);
        // A paused frame is repeated with each value that is changed.
        post.set_options(gpu.options_to_repeat(purpose.options()));
        Self { post, controls: Vec::new(), is_timed: false }
    }

    /// A second pipeline with another graph. Both share compiled pipelines; histories are separate.
    pub(super) fn clone_with(&self, graph: Graph) -> Self {
        let mut post = self.post.clone_for_view();
        post.change(graph);
        Self { post, controls: self.controls.clone(), is_timed: false }
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
    pub fn change(&mut self, graph: Graph, facts: Facts) {
        // A number that was changed in the text is likely to be changed again, so its next change needs no plan.
        if let Some(name) = self.tuned(&graph) {
            let _ = self.post.control(&name);
        }
        self.post.change(graph);
        self.post.set_facts(facts);
    }

    /// The parameter whose value is all that another graph changes.
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
        self.is_timed = false;
    }

    /// Whether a new plan is being made.
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
        if !self.is_timed && self.post.plan().is_some() {
            self.is_timed = true;
            self.post.time_passes()?;
        }
        let inputs: Vec<(&str, &TextureView)> =
            images.images.iter().map(|(name, view)| (name.as_str(), view)).collect();
        let blocks: Vec<(&str, &BlockData)> = images.blocks.iter().map(|(name, data)| (name.as_str(), data)).collect();
        let Moment { time, dt, kind } = moment;
        let (time, dt) = (time as f32, dt as f32);
        let frame = Frame { inputs: &inputs, blocks: &blocks, time, dt, kind, ..Frame::default() };
        Ok(self.post.encode(encoder, &frame)?)
    }

    /// The output that is shown: the first that is encoded, or else the first.
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

    /// The facts that are set.
    pub(super) fn facts(&self) -> &Facts {
        self.post.facts()
    }

    /// The texture of an image of the plan.
    pub fn image(&self, name: &str) -> Option<&wgpu::Texture> {
        self.post.image(name)
    }

    /// The newest times of passes, and whether the device measures them at all.
    pub fn pass_times(&self) -> Option<&PassTimes> {
        self.post.pass_times()
    }
}
