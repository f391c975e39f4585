//! Frames of sequences on the GPU, and what they cost.

use std::sync::Arc;

use afterimage::offline::Session;
use afterimage_gpu::{Clock, FrameTime, Gpu, GpuError};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{BufferLife, Pass};
use afterimage_plan::{Options, Plan};

use super::sequences::TestSequence;
use crate::LabError;
use crate::frame_time::frame_time;

/// The samples of a median where nothing else is asked for: on a GPU, and on a processor.
const SAMPLES: (u32, u32) = (50, 7);

/// The cost of a frame of a variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    pub time: FrameTime,
    /// The most bytes that transient images hold at once.
    pub bytes: u64,
    /// Bytes that all passes of a frame read and write.
    pub bytes_moved: u64,
    pub passes: usize,
}

impl Cost {
    /// The cost with the times of both measurements.
    pub(crate) fn joined(self, other: Self) -> Self {
        Self { time: self.time.joined(other.time), ..self }
    }

    /// The larger of each figure.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            time: if other.time.ms() > self.time.ms() { other.time } else { self.time },
            bytes: self.bytes.max(other.bytes),
            bytes_moved: self.bytes_moved.max(other.bytes_moved),
            passes: self.passes.max(other.passes),
        }
    }
}

/// Loads variants of a graph one after another, and times them.
pub(crate) struct SequenceRunner {
    pub(crate) session: Session,
    pub(crate) clock: Clock,
    options: Options,
    samples: Option<u32>,
}

impl SequenceRunner {
    /// Plans are made with these options; those of the reference with 32-bit intermediates, too.
    ///
    /// # Errors
    /// See [`Clock::new`].
    pub(crate) fn new(
        gpu: &Gpu,
        graph: &Graph,
        facts: Facts,
        options: Options,
        samples: Option<u32>,
    ) -> Result<Self, GpuError> {
        let session = Session::new(gpu, graph.clone(), facts, options);
        Ok(Self { session, clock: Clock::new(gpu)?, options, samples })
    }

    /// The number of samples of each time.
    pub(crate) fn samples(&self) -> u32 {
        self.samples.unwrap_or(if self.clock.is_gpu() { SAMPLES.0 } else { SAMPLES.1 })
    }

    /// The plan of a graph for the images of a sequence; `exact` stores intermediates in 32 bits.
    pub(crate) fn plan(&mut self, graph: &Graph, sequence: &TestSequence, exact: bool) -> Result<Arc<Plan>, LabError> {
        let options = Options { exact, ..self.options };
        self.session.change(graph.clone(), options);
        Ok(self.session.plan_for(sequence.size, sequence.images(0))?)
    }

    /// Loads the plan of a graph and starts at its first frame, so that all graphs have the same noise in a frame.
    pub(crate) fn load(&mut self, graph: &Graph, sequence: &TestSequence, exact: bool) -> Result<Arc<Plan>, LabError> {
        let options = Options { exact, ..self.options };
        self.session.change(graph.clone(), options);
        self.session.restart();
        Ok(self.session.load(sequence.size, sequence.images(0))?.clone())
    }

    /// The cost of a frame of the loaded plan with the first images of the sequence.
    pub(crate) fn cost(&mut self, sequence: &TestSequence, samples: u32) -> Result<Cost, LabError> {
        let time = frame_time(&self.session, &self.clock, samples, sequence.images(0))?;
        let plan = self.session.plan();
        Ok(Cost {
            time,
            bytes: plan.memory.bytes(plan.options.alias),
            bytes_moved: plan.bytes_moved(),
            passes: plan.passes.len(),
        })
    }
}

/// True if two plans run the same passes on images of the same formats. Images that fusion has removed do not count.
pub(crate) fn run_alike(a: &Plan, b: &Plan) -> bool {
    let used = |plan: &Plan| -> Vec<Option<ImageDesc>> {
        let resources = plan.work().flat_map(Pass::resources);
        resources.map(|resource| Some(plan.image(resource.image()?).desc)).collect()
    };
    let stages = |plan: &Plan| {
        let passes = plan.passes.iter().map(|planned| (planned.stage, planned.refresh.clone()));
        passes.collect::<Vec<_>>()
    };
    a.work().eq(b.work()) && stages(a) == stages(b) && used(a) == used(b)
}

/// True if frames of a plan depend on earlier frames.
pub(crate) fn has_histories(plan: &Plan) -> bool {
    reads_earlier_images(plan)
        || !plan.runs_all_passes()
        || plan.buffers.iter().any(|buffer| buffer.life == BufferLife::Persistent)
}

/// The number of frames of a still image on which a plan is measured, at most `most`. Images of earlier frames add up
/// over many. Buffers and retained results of one image are the same from the second frame on.
pub(crate) fn frames_of_still(plan: &Plan, most: u32) -> u32 {
    let frames = if reads_earlier_images(plan) { most } else { 2 };
    if has_histories(plan) { frames.min(most) } else { 1 }
}

/// True if frames of a plan read images of earlier frames.
pub(crate) fn reads_earlier_images(plan: &Plan) -> bool {
    plan.images.iter().any(|image| image.origin.previous_of().is_some())
}
