//! Frames on the GPU, and what they cost.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use afterimage_gpu::{Executor, Frame, Gpu, Texels, download};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{BufferLife, Origin, Resource};
use afterimage_plan::{GivenImage, Options, Plan, PlanRequest, plan};

use super::clips::Clip;
use crate::failure::Failure;

/// A processor's frames before the first that is timed: caches fill.
const WARM_UP: u32 = 2;

/// A GPU with little to do lowers its clocks, an H200 to a fifth, and raises them only under work without gaps, in steps of up to 0.3 s.
/// When no frame was faster for so long, there is no step left.
const SETTLED: Duration = Duration::from_millis(500);
/// No GPU is worked longer than this before it is measured.
const MOST_HEATING: Duration = Duration::from_secs(4);
/// How long a GPU keeps its clocks without work.
const STAYS_HOT: Duration = Duration::from_secs(1);
/// Frames that are handed over at once, so that there are no gaps, and about how long they may take together.
const BATCH: f64 = 16.0;
const BATCH_MS: f64 = 20.0;

/// Which clock times frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Watch {
    /// Timestamps on the GPU.
    Gpu,
    /// From submission to completion, as the host sees it.
    Host,
}

impl Watch {
    /// The name in tables and files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Host => "host",
        }
    }
}

/// What a frame of a variant costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cost {
    /// Milliseconds of the median frame.
    pub(crate) ms: f64,
    /// The most bytes that transient images hold.
    pub(crate) bytes: u64,
    /// Bytes that passes read and write in a frame.
    pub(crate) moved: u64,
    /// How many passes there are.
    pub(crate) passes: usize,
}

impl Cost {
    /// The larger of each.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            ms: self.ms.max(other.ms),
            bytes: self.bytes.max(other.bytes),
            moved: self.moved.max(other.moved),
            passes: self.passes.max(other.passes),
        }
    }
}

/// Runs one graph after the other on the same device.
pub(crate) struct Runner<'g> {
    gpu: &'g Gpu,
    executor: Executor,
    /// The plan in use as it was made: the executor's may lie in the heap of the one before.
    planned: Option<Arc<Plan>>,
    facts: Facts,
    options: Options,
    repeats: Option<u32>,
    watch: Watch,
    /// When the GPU was last known to run at its full clocks.
    hot: Option<Instant>,
}

impl<'g> Runner<'g> {
    /// PlanCache are made with these options; the truth is exact beside that.
    pub(crate) fn new(gpu: &'g Gpu, facts: Facts, options: Options, repeats: Option<u32>) -> Self {
        let is_processor = gpu.is_processor();
        // Timestamps of a processor say when commands were recorded by the driver's threads, not what they took.
        let watch = if is_processor { Watch::Host } else { Watch::Gpu };
        let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
        Self { gpu, executor, planned: None, facts, options, repeats, watch, hot: None }
    }

    /// Which clock times frames; a device without timestamps turns out when the first plan is loaded.
    pub(crate) fn watch(&self) -> Watch {
        self.watch
    }

    /// How often the frame is timed.
    pub(crate) fn repeats(&self) -> u32 {
        self.repeats.unwrap_or(if self.watch == Watch::Gpu { 50 } else { 7 })
    }

    /// The plan of a graph for the images of a clip; `exact` for 32-bit intermediates.
    pub(crate) fn plan(&self, graph: &Graph, clip: &Clip, exact: bool) -> Result<Plan, Failure> {
        let given = |desc: ImageDesc| GivenImage { desc, finite: false };
        let inputs: BTreeMap<_, _> =
            clip.images(0).iter().map(|image| (image.input.clone(), given(image.desc))).collect();
        let requirement = |desc: &ImageDesc| self.executor.requirement(desc);
        let setting = PlanRequest {
            size: clip.size,
            inputs,
            facts: self.facts.clone(),
            caps: self.gpu.caps.clone(),
            options: Options { exact, ..self.options },
            requirement: &requirement,
        };
        Ok(plan(graph, &setting)?)
    }

    /// Makes a plan the one that runs, from its first frame: all have the same grain in the same frame.
    pub(crate) fn load(&mut self, plan: Plan) -> Result<(), Failure> {
        let plan = Arc::new(plan);
        self.executor.count_from(0);
        self.executor.load(plan.clone())?;
        self.planned = Some(plan);
        if self.watch == Watch::Gpu && !self.executor.enable_timing() {
            self.watch = Watch::Host;
        }
        Ok(())
    }

    /// Renders a frame of the clip.
    pub(crate) fn render(&mut self, clip: &Clip, frame: usize) -> Result<(), Failure> {
        let clock = clip.clock(frame);
        let images = clip.images(frame);
        let views: Vec<_> = images.iter().map(|image| image.texture.create_view(&Default::default())).collect();
        let inputs: Vec<_> = images.iter().map(|image| image.input.as_str()).zip(&views).collect();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &inputs, outputs: &[], time: clock.time, dt: clock.dt, reset: clock.reset };
        self.executor.encode(&mut encoder, &frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The texels of an output of the last frame.
    pub(crate) fn output(&self, name: &str) -> Result<Texels, Failure> {
        let texture = self.executor.output(name).expect("the executor keeps a texture for each output");
        Ok(download(&self.gpu.device, &self.gpu.queue, texture)?)
    }

    /// What the last frame of the clip costs with the plan in use.
    pub(crate) fn cost(&mut self, clip: &Clip) -> Result<Cost, Failure> {
        let batch = self.heat(clip)?;
        let mut times = (0..self.repeats()).map(|_| self.timed(clip, batch)).collect::<Result<Vec<f64>, _>>()?;
        self.hot = Some(Instant::now());
        times.sort_by(f64::total_cmp);
        let plan = self.planned.as_ref().expect("a plan was loaded");
        Ok(Cost {
            ms: times[times.len() / 2],
            bytes: plan.memory.bytes(plan.options.alias),
            moved: plan.bytes_moved(),
            passes: plan.recording.passes.len(),
        })
    }

    /// Works the device until it runs at its full clocks; how many frames shall be handed over at once.
    fn heat(&mut self, clip: &Clip) -> Result<u32, Failure> {
        let first = self.timed(clip, WARM_UP)?;
        if self.watch == Watch::Host {
            return Ok(1);
        }
        let batch = (BATCH_MS / first).clamp(2.0, BATCH) as u32;
        let is_hot = self.hot.is_some_and(|hot| hot.elapsed() < STAYS_HOT);
        let (start, mut best, mut since) = (Instant::now(), f64::INFINITY, Instant::now());
        while !is_hot && since.elapsed() < SETTLED && start.elapsed() < MOST_HEATING {
            let ms = self.timed(clip, batch)?;
            if ms < 0.97 * best {
                (best, since) = (ms, Instant::now());
            }
        }
        Ok(batch)
    }

    /// Milliseconds of the last of so many frames, one right after the other.
    fn timed(&mut self, clip: &Clip, frames: u32) -> Result<f64, Failure> {
        for _ in 1..frames {
            self.render(clip, clip.len() - 1)?;
        }
        let start = Instant::now();
        self.render(clip, clip.len() - 1)?;
        let on_gpu = match self.watch {
            Watch::Gpu => self.executor.pass_times(),
            Watch::Host => None,
        };
        if let Some(passes) = on_gpu {
            return Ok(passes.iter().sum());
        }
        let waited = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| Failure::machine(format!("the GPU did not finish: {error}")))?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }
}

/// Whether two plans do the same: the same passes on images of the same formats. Images that fusion has removed do not matter.
pub(crate) fn run_alike(a: &Plan, b: &Plan) -> bool {
    let desc = |plan: &Plan, resource: Resource| match resource {
        Resource::Image(image) => Some(plan.recording.image(image).desc),
        Resource::Buffer(_) => None,
    };
    let touched = |plan: &Plan| -> Vec<Option<ImageDesc>> {
        let resources = plan.recording.passes.iter().flat_map(|pass| pass.reads().into_iter().chain(pass.writes()));
        resources.map(|resource| desc(plan, resource)).collect()
    };
    a.recording.passes == b.recording.passes && a.stages == b.stages && touched(a) == touched(b)
}

/// Whether a plan's frames depend on earlier ones.
pub(crate) fn remembers(plan: &Plan) -> bool {
    let images = plan.recording.images.iter().any(|image| matches!(image.origin, Origin::Previous { .. }));
    images || plan.recording.buffers.iter().any(|buffer| buffer.life == BufferLife::Persistent)
}
