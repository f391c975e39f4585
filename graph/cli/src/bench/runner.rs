//! A pipeline that is loaded once and rendered again and again.

use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, Gpu, Texels, download};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::ImageDesc;
use afterimage_plan::{GivenImage, Options, Plan, PlanRequest, Requirement, plan};
use wgpu::{CommandEncoder, TextureView};

use super::clock::{Stopwatch, median, wait};
use super::inputs::Inputs;
use crate::failure::Failure;

/// Seconds between two frames.
const STEP: f32 = 1.0 / 60.0;

pub(super) struct Runner<'a> {
    gpu: &'a Gpu,
    executor: Executor,
    inputs: Vec<(&'a str, &'a TextureView)>,
    frames: u32,
}

impl<'a> Runner<'a> {
    /// PlanCache the graph for these inputs and loads the plan.
    pub(super) fn new(
        gpu: &'a Gpu,
        inputs: &'a Inputs,
        graph: &Graph,
        facts: Facts,
        options: Options,
        mut executor: Executor,
    ) -> Result<Self, Failure> {
        let plan = Self::plan_of(gpu, inputs, graph, facts, options, |desc| executor.requirement(desc))?;
        executor.load(Arc::new(plan))?;
        let inputs = inputs.images.iter().map(|(name, view, _)| (name.as_str(), view)).collect();
        Ok(Self { gpu, executor, inputs, frames: 0 })
    }

    /// The plan of the graph for these inputs.
    pub(super) fn plan_of(
        gpu: &Gpu,
        inputs: &Inputs,
        graph: &Graph,
        facts: Facts,
        options: Options,
        requirement: impl Fn(&ImageDesc) -> Requirement,
    ) -> Result<Plan, Failure> {
        let given = |desc: &ImageDesc| GivenImage { desc: *desc, finite: false };
        let setting = PlanRequest {
            size: inputs.size,
            inputs: inputs.images.iter().map(|(name, _, desc)| (name.clone(), given(desc))).collect(),
            facts,
            caps: gpu.caps.clone(),
            options,
            requirement: &requirement,
        };
        Ok(plan(graph, &setting)?)
    }

    /// Records the next frame.
    pub(super) fn encode(&mut self, encoder: &mut CommandEncoder) -> Result<(), Failure> {
        let frame = frame(&self.inputs, self.frames);
        self.executor.encode(encoder, &frame)?;
        self.frames += 1;
        Ok(())
    }

    /// Renders the next frame and waits for it.
    pub(super) fn frame(&mut self) -> Result<(), Failure> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder)?;
        self.gpu.queue.submit([encoder.finish()]);
        wait(self.gpu)
    }

    /// Median milliseconds of each pass: by timestamps between them, or, where those cannot be trusted, each submitted alone.
    pub(super) fn pass_times(&mut self, stopwatch: &Stopwatch<'_>, frames: u32) -> Result<Vec<f64>, Failure> {
        let passes = self.plan().recording.passes.len();
        if !stopwatch.is_gpu() || !self.executor.enable_timing() {
            let (inputs, now, executor) = (&self.inputs, self.frames, &mut self.executor);
            let mut alone = |pass| {
                stopwatch.median(frames, |encoder| Ok(executor.encode_pass(encoder, &frame(inputs, now), pass)?))
            };
            return (0..passes).map(&mut alone).collect();
        }
        let mut samples = vec![Vec::new(); passes];
        for _ in 0..frames {
            self.frame()?;
            let times = self.executor.pass_times().unwrap_or_default();
            samples.iter_mut().zip(times).for_each(|(samples, time)| samples.push(time));
        }
        Ok(samples.into_iter().map(median).collect())
    }

    /// The first output of the last frame.
    pub(super) fn picture(&self) -> Result<Texels, Failure> {
        let output = self.plan().outputs.first().and_then(|output| self.executor.output(&output.name));
        let texture = output.expect("a pipeline has an output, and the executor a texture for it");
        Ok(download(&self.gpu.device, &self.gpu.queue, texture)?)
    }

    pub(super) fn plan(&self) -> &Arc<Plan> {
        self.executor.plan().expect("a plan was loaded")
    }

    /// The driver's pipelines.
    pub(super) fn pipelines(&self) -> Vec<u8> {
        self.executor.pipeline_cache_data().unwrap_or_default()
    }
}

fn frame<'v>(inputs: &'v [(&'v str, &'v TextureView)], number: u32) -> Frame<'v> {
    let reset = number == 0;
    Frame { inputs, outputs: &[], time: number as f32 * STEP, dt: if reset { 0.0 } else { STEP }, reset }
}
