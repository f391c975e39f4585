//! The figures of kinds, as JSON and as text.

use std::fmt;

use serde::Serialize;

/// The figures of all kinds.
#[derive(Debug, Serialize)]
pub(crate) struct KindsReport {
    /// The adapter.
    pub(crate) adapter: String,
    /// Its driver.
    pub(crate) driver: String,
    /// `gpu`: timestamps on the GPU; `host`: the host's clock, from recording to completion.
    pub(crate) clock: &'static str,
    /// Samples of each median.
    pub(crate) frames: u32,
    /// The copy bandwidth of the device in gigabytes per second; reads and writes both count.
    pub(crate) copy_gbps: f64,
    /// The kinds that ran.
    pub(crate) kinds: Vec<KindFigures>,
    /// The others.
    pub(crate) skipped: Vec<SkippedKind>,
}

/// A kind that did not run.
#[derive(Debug, Serialize)]
pub(crate) struct SkippedKind {
    /// Its name.
    pub(crate) kind: String,
    /// Why.
    pub(crate) why: String,
}

/// A kind on its own.
#[derive(Debug, Serialize)]
pub(crate) struct KindFigures {
    /// Its name.
    pub(crate) kind: String,
    /// Its passes.
    pub(crate) passes: usize,
    /// True if other nodes make its inputs or show its result. Then times are those of its own passes, which do not
    /// overlap, and else those of the frame.
    pub(crate) with_others: bool,
    /// Parameters that are not at their defaults, because the kind changes nothing with these.
    pub(crate) set: Vec<String>,
    /// The figures at each size.
    pub(crate) sizes: Vec<SizeFigures>,
}

impl KindFigures {
    pub(super) fn new(kind: &str) -> Self {
        Self { kind: kind.to_owned(), passes: 0, with_others: false, set: Vec::new(), sizes: Vec::new() }
    }
}

/// A kind at one size.
#[derive(Debug, Serialize)]
pub(crate) struct SizeFigures {
    /// Width and height of a frame.
    pub(crate) size: [u32; 2],
    /// Milliseconds.
    pub(crate) ms: f64,
    /// Bytes of its inputs and of its result.
    pub(crate) least_bytes: u64,
    /// These per time, as a share of the copy bandwidth.
    pub(crate) share: f64,
    /// Bytes that its passes read and write, images between them included.
    pub(crate) moved_bytes: u64,
    /// These per time, as a share of the copy bandwidth.
    pub(crate) moved_share: f64,
    /// The same work written by hand, for kinds that have a baseline.
    pub(crate) baseline: Option<BaselineFigures>,
}

/// A baseline.
#[derive(Debug, Serialize)]
pub(crate) struct BaselineFigures {
    /// Its milliseconds.
    pub(crate) ms: f64,
    /// The mean difference of a channel from the kind's result. Both are compressed to x / (1 + x), from 0 to 1.
    pub(crate) mean_difference: f64,
    /// The largest one.
    pub(crate) max_difference: f64,
    /// The mean difference of the kind's result from its source: what the kind does.
    pub(crate) effect: f64,
}

/// The mean and the largest difference of a color channel of light.
pub(super) fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> (f64, f64) {
    let compressed = |x: f32| f64::from(x.max(0.0)) / (1.0 + f64::from(x.max(0.0)));
    let channels = a.iter().zip(b).flat_map(|(a, b)| [0, 1, 2].map(|c| (compressed(a[c]) - compressed(b[c])).abs()));
    let (sum, largest) = channels.fold((0.0, 0.0_f64), |(sum, largest), off| (sum + off, largest.max(off)));
    (sum / (3 * a.len().max(1)) as f64, largest)
}

impl fmt::Display for KindsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({}), {} clock, medians of {} frames", self.adapter, self.driver, self.clock, self.frames)?;
        writeln!(f, "copy bandwidth {:.0} GB/s", self.copy_gbps)?;
        writeln!(
            f,
            "{:<20} {:>11} {:>6} {:>9} {:>9} {:>8} {:>8}",
            "kind", "size", "passes", "ms", "MB", "of copy", "moved"
        )?;
        for row in &self.kinds {
            for SizeFigures { size: [width, height], ms, least_bytes, share, moved_share, baseline, .. } in &row.sizes {
                let (size, megabytes) = (format!("{width}x{height}"), *least_bytes as f64 * 1e-6);
                let (share, moved) = (100.0 * share, 100.0 * moved_share);
                writeln!(
                    f,
                    "{:<20} {size:>11} {:>6} {ms:>9.4} {megabytes:>9.2} {share:>6.0} % {moved:>6.0} %",
                    row.kind, row.passes
                )?;
                if let Some(BaselineFigures { ms, mean_difference, max_difference, effect }) = baseline {
                    writeln!(
                        f,
                        "  written by hand: {ms:.4} ms; the results differ by {mean_difference:.5} on average and \
                         {max_difference:.4} at most, where the kind changes its source by {effect:.5}"
                    )?;
                }
            }
            if row.with_others {
                writeln!(f, "  the time of its own passes, without those of nodes that make its inputs")?;
            }
            if !row.set.is_empty() {
                writeln!(f, "  with {}, because its defaults change nothing", row.set.join(", "))?;
            }
        }
        for SkippedKind { kind, why } in &self.skipped {
            writeln!(f, "`{kind}` is not measured: {why}")?;
        }
        Ok(())
    }
}
