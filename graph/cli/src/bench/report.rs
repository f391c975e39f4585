//! What was measured, as JSON and as a table.

use std::fmt;

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde::Serialize;

use super::peer::{PeerReport, Times};

/// Everything about one pipeline at one size. Times are medians.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) pipeline: String,
    pub(super) adapter: String,
    pub(super) driver: String,
    pub(super) size: [u32; 2],
    pub(super) frames: u32,
    /// `gpu`: timestamps on the GPU; `host`: the wall clock, from recording to the end.
    pub(super) clock: &'static str,
    /// Milliseconds of a frame by that clock.
    pub(super) gpu_ms: f64,
    /// Microseconds that the processor records and submits a frame.
    pub(super) host_us: f64,
    pub(super) host: HostReport,
    /// Gigabytes a second that the device copies, reads and writes counted both.
    pub(super) copy_gbps: f64,
    /// Bytes that the passes of a frame must move.
    pub(super) bytes: u64,
    /// Share of the copy bandwidth that the whole frame reaches.
    pub(super) share: f64,
    /// Bytes of transient images, outputs and histories.
    pub(super) memory: u64,
    pub(super) first_frame_ms: FirstFrame,
    pub(super) peer: Option<PeerReport>,
    pub(super) passes: Vec<PassReport>,
}

#[derive(Debug, Serialize)]
pub(super) struct HostReport {
    pub(super) encode_us: f64,
    pub(super) submit_us: f64,
}

/// Milliseconds from the pipeline's text to its first picture, on a device that is open.
#[derive(Debug, Serialize)]
pub(super) struct FirstFrame {
    /// Without the driver's pipelines.
    pub(super) cold: f64,
    /// With them.
    pub(super) warm: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct PassReport {
    pub(super) name: String,
    pub(super) nodes: Vec<String>,
    pub(super) stage: &'static str,
    pub(super) ms: f64,
    pub(super) bytes: u64,
    pub(super) share: f64,
}

/// A table whose columns after the first are numbers.
pub(super) fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(header.to_vec());
    table.add_rows(rows);
    table.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 * 1e-6)
}

impl Report {
    fn passes(&self) -> Table {
        let row = |pass: &PassReport| {
            let name = if pass.stage == "fragment" { format!("{} (drawn)", pass.name) } else { pass.name.clone() };
            vec![name, format!("{:.4}", pass.ms), megabytes(pass.bytes), percent(pass.share)]
        };
        let sum: f64 = self.passes.iter().map(|pass| pass.ms).sum();
        let all = vec!["all, one by one".into(), format!("{sum:.4}"), megabytes(self.bytes), String::new()];
        table(&["pass", "ms", "MB", "of copy"], self.passes.iter().map(row).chain([all]))
    }

    fn peer_lines(&self, peer: &Times, what: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = |time: f64| format!("{time:.4} ms; ours takes {:.2} of that", self.gpu_ms / time);
        writeln!(f, "{what}")?;
        writeln!(f, "  draws                    {}", times(peer.fragment_ms))?;
        writeln!(f, "  dispatches               {}", times(peer.compute_ms))?;
        if let Some(packed) = peer.compute_rg11b10_ms {
            writeln!(f, "  with levels in rg11b10   {}", times(packed))?;
        }
        let (largest, mean) = (peer.max_difference, peer.mean_difference);
        writeln!(f, "  its picture differs from ours by {largest:.4} at most, {mean:.5} on average")
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(
            f,
            "{} at {width}x{height} on {} ({}), medians of {}",
            self.pipeline, self.adapter, self.driver, self.frames
        )?;
        writeln!(f, "{}", self.passes())?;
        let clock = if self.clock == "gpu" { "GPU, a frame              " } else { "host wall clock, a frame  " };
        writeln!(f, "{clock} {:.4} ms, {} of copying", self.gpu_ms, percent(self.share))?;
        let HostReport { encode_us, submit_us } = self.host;
        writeln!(f, "host, a frame              {encode_us:.1} us to record, {submit_us:.1} us to submit")?;
        writeln!(f, "this device copies         {:.0} GB/s", self.copy_gbps)?;
        writeln!(f, "memory                     {} MB", megabytes(self.memory))?;
        let FirstFrame { cold, warm } = self.first_frame_ms;
        writeln!(f, "text to first frame        {cold:.1} ms, {warm:.1} ms with the driver's pipelines at hand")?;
        let Some(peer) = &self.peer else { return Ok(()) };
        self.peer_lines(&peer.same, "written by hand, the same work", f)?;
        self.peer_lines(&peer.light, "written by hand, less work: half the pixels, four plain loads each, no dither", f)
    }
}
