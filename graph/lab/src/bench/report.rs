//! The figures of a pipeline, as JSON and as text.

use std::fmt;

use afterimage_gpu::FrameTime;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde::Serialize;

/// Everything about one pipeline at one size. Times are medians.
#[derive(Debug, Serialize)]
pub struct BenchReport {
    /// The name of the pipeline.
    pub pipeline: String,
    pub adapter: String,
    pub driver: String,
    /// Width and height of a frame.
    pub size: [u32; 2],
    /// The time of a frame.
    #[serde(flatten)]
    pub frame: FrameFigures,
    /// Microseconds of the host for recording, finishing and submitting a frame.
    pub host_us: f64,
    pub host: HostTimes,
    /// The copy bandwidth of the device in gigabytes per second; reads and writes both count.
    pub copy_gbps: f64,
    /// The shape of the copy that reached it: texels or vectors of an invocation, or a command.
    pub copy_shape: &'static str,
    /// Bytes that the passes of a frame read and write.
    pub bytes: u64,
    /// The frame's bytes per time, as a share of the copy bandwidth.
    pub share: f64,
    /// Bytes of the images on the device.
    pub memory: MemoryFigures,
    /// The time to the first frame.
    pub first_frame_ms: FirstFrame,
    /// The driver's pipelines, for the next run of the program; empty if the device has no cache.
    #[serde(skip)]
    pub pipelines: Vec<u8>,
    /// The split by passes. These times do not overlap, so their sum is more than the frame.
    pub passes: Vec<PassReport>,
}

/// The time of a frame, as [`Clock`](afterimage_gpu::Clock) defines it.
#[derive(Debug, Serialize)]
pub struct FrameFigures {
    /// Samples of the median, and of all other medians.
    frames: u32,
    /// `gpu`: timestamps on the GPU; `host`: the host's clock, from recording to completion.
    clock: &'static str,
    gpu_ms: f64,
    /// The interval that holds the true median with a confidence of 95 %.
    gpu_ms_interval: [f64; 2],
    #[serde(skip)]
    time: FrameTime,
}

impl FrameFigures {
    pub fn time(&self) -> FrameTime {
        self.time
    }
}

impl From<FrameTime> for FrameFigures {
    fn from(time: FrameTime) -> Self {
        let (gpu_ms, gpu_ms_interval) = (time.ms(), time.interval());
        Self { frames: time.samples(), clock: time.source().name(), gpu_ms, gpu_ms_interval, time }
    }
}

/// The host's work for a frame.
#[derive(Debug, Serialize)]
pub struct HostTimes {
    /// Microseconds to record its commands.
    pub record_us: f64,
    /// Microseconds of wgpu's `finish`, which checks and encodes them.
    pub finish_us: f64,
    /// Microseconds to submit it.
    pub submit_us: f64,
}

/// Bytes of the images of a plan on the device.
#[derive(Debug, Serialize)]
pub struct MemoryFigures {
    /// Images of one frame, which share memory.
    pub transient: u64,
    /// Outputs, histories, baked LUTs and cached results, which share none.
    pub kept: u64,
}

/// Milliseconds from the pipeline's text to its first frame, on an open device.
#[derive(Debug, Serialize)]
pub struct FirstFrame {
    /// Without the driver's pipelines.
    pub cold: f64,
    /// With them.
    pub warm: f64,
}

#[derive(Debug, Serialize)]
pub struct PassReport {
    /// The label of the pass.
    pub name: String,
    /// The nodes that it computes.
    pub nodes: Vec<String>,
    /// `compute` or `fragment`.
    pub stage: &'static str,
    pub ms: f64,
    /// True for a pass that evaluates a baked LUT, in frames before which a number in it has changed.
    pub runs_on_change: bool,
    /// Bytes that it reads and writes.
    pub bytes: u64,
    /// Its bytes per time, as a share of the copy bandwidth.
    pub share: f64,
}

/// A table whose columns after the first are numbers.
pub(crate) fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(header.to_vec());
    table.add_rows(rows);
    table.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 * 1e-6)
}

impl BenchReport {
    fn passes(&self) -> Table {
        let row = |pass: &PassReport| {
            let drawn = if pass.stage == "fragment" { " (drawn)" } else { "" };
            let seldom = if pass.runs_on_change { " (after a change)" } else { "" };
            vec![
                format!("{}{drawn}{seldom}", pass.name),
                format!("{:.4}", pass.ms),
                megabytes(pass.bytes),
                percent(pass.share),
            ]
        };
        let sum: f64 = self.passes.iter().filter(|pass| !pass.runs_on_change).map(|pass| pass.ms).sum();
        let all = vec!["sum, without overlap".into(), format!("{sum:.4}"), megabytes(self.bytes), String::new()];
        table(&["pass", "ms", "MB", "of copy"], self.passes.iter().map(row).chain([all]))
    }
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(
            f,
            "{} at {width}x{height} on {} ({}), medians of {}",
            self.pipeline, self.adapter, self.driver, self.frame.frames
        )?;
        writeln!(f, "{}", self.passes())?;
        let clock = if self.frame.clock == "gpu" { "GPU, a frame              " } else { "host clock, a frame       " };
        let (ms, [low, high]) = (self.frame.gpu_ms, self.frame.gpu_ms_interval);
        let share = percent(self.share);
        writeln!(f, "{clock} {ms:.4} ms ({low:.4} to {high:.4} with 95 %), {share} of the copy bandwidth")?;
        let HostTimes { record_us, finish_us, submit_us } = self.host;
        writeln!(
            f,
            "host, a frame              {record_us:.1} us to record, {finish_us:.1} us to finish, {submit_us:.1} us to \
             submit"
        )?;
        writeln!(f, "copy bandwidth             {:.0} GB/s ({})", self.copy_gbps, self.copy_shape)?;
        let MemoryFigures { transient, kept } = self.memory;
        writeln!(
            f,
            "memory                     {} MB of transient images, {} MB kept: outputs, histories, baked LUTs, \
             cached results",
            megabytes(transient),
            megabytes(kept)
        )?;
        let FirstFrame { cold, warm } = self.first_frame_ms;
        writeln!(f, "text to first frame        {cold:.1} ms, {warm:.1} ms with the driver's pipelines")
    }
}
