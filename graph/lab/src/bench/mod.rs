//! The cost of a pipeline on this device: frame, passes and host work, next to the bandwidth of the device.

mod copy;
mod report;

use std::collections::VecDeque;
use std::time::Instant;

use afterimage::offline::{LutErrors, Session, faults, timing};
use afterimage_gpu::{Clock, FrameStep, Gpu, InputImage, median};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::{Baked, Options, Plan, Stage};

pub use copy::{CopyBandwidth, bandwidth};
pub use report::{BenchReport, FirstFrame, FrameFigures, HostTimes, MemoryFigures, PassReport};

use crate::frame_time::frame_time;
use crate::{LabError, scene};

/// Frames that a renderer has in flight while it records another.
const IN_FLIGHT: usize = 2;

#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Pixels of a frame.
    pub size: Size,
    /// Samples of each median.
    pub samples: u32,
    /// The host guarantees that its images hold finite numbers only.
    pub finite: bool,
    pub facts: Facts,
    pub options: Options,
}

/// Measures a pipeline on the built-in scene. `load` reads the pipeline; it is called again for each start from the
/// text.
///
/// # Errors
/// Errors of `load`, and of the device.
pub fn bench<E: From<LabError>>(
    gpu: &Gpu,
    registry: &Registry,
    name: &str,
    load: &dyn Fn() -> Result<Graph, E>,
    options: &BenchOptions,
) -> Result<BenchReport, E> {
    let graph = load()?;
    let mut images = scene::still(gpu, registry, &graph, options.size)?;
    images.iter_mut().for_each(|image| image.finite = options.finite);
    let (first_frame, session) = starts(gpu, load, &images, options)?;
    Ok(Bench { gpu, session, images, options }.report(name, first_frame)?)
}

/// A table of colors next to the nodes in whose place it is, in codes of 8 bits.
pub struct TableError {
    pub nodes: Vec<String>,
    pub size: u32,
    /// The 99th and the 99.9th percentile of random colors, and the largest error, for each gamut of
    /// `LutErrors::GAMUTS`.
    pub codes: [[f32; 3]; 4],
    /// The largest error of grays.
    pub gray: f32,
    /// Steps of a ramp of grays at which the table falls, and the nodes do not.
    pub reversals: usize,
}

impl TableError {
    fn new(baked: &Baked, errors: &LutErrors) -> Self {
        let grays = &errors.grays;
        let codes = errors.colors.each_ref().map(|colors| {
            let last = colors.len() - 1;
            [last - last / 100, last - last / 1000, last].map(|at| 255.0 * colors[at])
        });
        let gray = grays.iter().map(|[exact, shown]| (exact - shown).abs()).fold(0.0, f32::max);
        let falls = |pair: &&[[f32; 2]]| {
            let [exact, shown] = [0, 1].map(|side: usize| pair[0][side] - pair[1][side]);
            255.0 * (shown - exact.max(0.0)) > 1e-3
        };
        let reversals = grays.windows(2).filter(falls).count();
        Self { nodes: baked.nodes.clone(), size: baked.size, codes, gray: 255.0 * gray, reversals }
    }
}

/// Compares the tables of a pipeline with their nodes, on the device.
///
/// # Errors
/// Errors of the device.
pub fn table_errors(
    gpu: &Gpu,
    registry: &Registry,
    graph: Graph,
    options: &BenchOptions,
) -> Result<Vec<TableError>, LabError> {
    let images = scene::still(gpu, registry, &graph, options.size)?;
    let mut session = Session::new(gpu, graph, options.facts.clone(), options.options);
    let errors = faults::lut_errors(&mut session, options.size, &images)?;
    let baked = &session.plan().savings.baked;
    Ok(baked.iter().zip(&errors).map(|(baked, errors)| TableError::new(baked, errors)).collect())
}

/// From the text to the first frame, without the driver's pipelines and with them; the second session is returned.
fn starts<E: From<LabError>>(
    gpu: &Gpu,
    load: &dyn Fn() -> Result<Graph, E>,
    images: &[InputImage],
    options: &BenchOptions,
) -> Result<(FirstFrame, Session), E> {
    let start = |pipelines: &[u8]| -> Result<(f64, Session), E> {
        let begin = Instant::now();
        let (graph, facts) = (load()?, options.facts.clone());
        let mut session = Session::with_pipeline_cache(gpu, graph, facts, options.options, pipelines);
        session.render(options.size, images, FrameStep::FIRST).map_err(LabError::from)?;
        gpu.wait().map_err(LabError::from)?;
        Ok((begin.elapsed().as_secs_f64() * 1e3, session))
    };
    let (cold, mut first) = start(&[])?;
    let known = first.post().executor().pipeline_cache_data().unwrap_or_default();
    let (warm, session) = start(&known)?;
    Ok((FirstFrame { cold, warm }, session))
}

/// The state of a measurement.
struct Bench<'a> {
    gpu: &'a Gpu,
    session: Session,
    images: Vec<InputImage>,
    options: &'a BenchOptions,
}

impl Bench<'_> {
    fn report(mut self, name: &str, first_frame: FirstFrame) -> Result<BenchReport, LabError> {
        let clock = Clock::new(self.gpu)?;
        let frame = frame_time(&self.session, &clock, self.options.samples, &self.images)?;
        let host = self.host_times()?;
        let CopyBandwidth { gbps: copy_gbps, shape: copy_shape } = bandwidth(self.gpu, &clock)?;
        let pass_times = timing::pass_times(&mut self.session, &clock, self.options.samples, &self.images)?;
        let pipelines = self.session.post().executor().pipeline_cache_data().unwrap_or_default();
        let plan = self.session.plan();
        let info = self.gpu.adapter.get_info();
        Ok(BenchReport {
            pipeline: name.to_owned(),
            adapter: info.name,
            driver: format!("{} {}", info.driver, info.driver_info),
            size: [self.options.size.width, self.options.size.height],
            frame: frame.into(),
            host_us: host.record_us + host.finish_us + host.submit_us,
            host,
            copy_gbps,
            copy_shape,
            bytes: plan.bytes_moved(),
            share: share(plan.bytes_moved(), frame.ms(), copy_gbps),
            memory: MemoryFigures { transient: plan.memory.bytes(plan.options.alias), kept: plan.memory.kept },
            first_frame_ms: first_frame,
            pipelines,
            passes: passes(plan, &pass_times, copy_gbps),
        })
    }

    /// The host's work for a frame, without timestamps, in a program that does not wait for each frame. On a processor
    /// earlier frames would use the same cores: there each frame ends before the next begins.
    fn host_times(&mut self) -> Result<HostTimes, LabError> {
        let in_flight = if self.gpu.is_processor() { 0 } else { IN_FLIGHT };
        let mut times: [Vec<f64>; 3] = Default::default();
        let mut submitted = VecDeque::new();
        for number in 0..self.options.samples {
            let start = Instant::now();
            let mut encoder = self.gpu.encoder();
            self.session.encode(&mut encoder, &self.images, timing::timed_step(number))?;
            let recorded = Instant::now();
            let commands = encoder.finish();
            let finished = Instant::now();
            submitted.push_back(self.gpu.queue.submit([commands]));
            let spans = [recorded - start, finished - recorded, finished.elapsed()];
            times.iter_mut().zip(spans).for_each(|(times, span)| times.push(span.as_secs_f64() * 1e6));
            if submitted.len() > in_flight {
                self.gpu.wait_for(submitted.pop_front())?;
            }
        }
        self.gpu.wait()?;
        let [record_us, finish_us, submit_us] = times.map(median);
        Ok(HostTimes { record_us, finish_us, submit_us })
    }
}

/// Bytes per time as a share of the copy bandwidth; 0 for a time of 0.
fn share(bytes: u64, milliseconds: f64, copy_gbps: f64) -> f64 {
    if milliseconds > 0.0 { bytes as f64 * 1e-6 / milliseconds / copy_gbps } else { 0.0 }
}

fn passes(plan: &Plan, times: &[f64], copy_gbps: f64) -> Vec<PassReport> {
    let mut reports = Vec::new();
    for (index, (planned, ms)) in plan.passes.iter().zip(times).enumerate() {
        let bytes = plan.bytes_moved_by(index);
        reports.push(PassReport {
            name: planned.pass.label.clone(),
            nodes: planned.pass.nodes.clone(),
            stage: if planned.stage == Stage::Compute { "compute" } else { "fragment" },
            ms: *ms,
            runs_on_change: plan.runs_on_change(index),
            bytes,
            share: share(bytes, *ms, copy_gbps),
        });
    }
    reports
}

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn a_share_of_the_bandwidth_is_bytes_per_time_over_that_of_a_copy() {
        // 2 MB in 4 ms are half a gigabyte in a second.
        assert_eq!(share(2_000_000, 4.0, 0.5), 1.0);
        assert_eq!(share(2_000_000, 1.0, 10.0), 0.2);
        assert_eq!(share(2_000_000, 0.0, 10.0), 0.0);
    }
}
