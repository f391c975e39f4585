//! The figures of kinds, as JSON and as Markdown.

use std::fmt;

use serde::Serialize;

use crate::bench::report::{megabytes, percent, table};

/// The figures of all kinds.
#[derive(Debug, Serialize)]
pub struct KindsReport {
    /// The adapter.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// `gpu`: timestamps on the GPU; `host`: the host's clock, from recording to completion.
    pub clock: &'static str,
    /// Samples of each median.
    pub frames: u32,
    /// The copy bandwidth of the device in gigabytes per second; reads and writes both count.
    pub copy_gbps: f64,
    /// The kinds that ran.
    pub kinds: Vec<KindFigures>,
    /// The others.
    pub skipped: Vec<SkippedKind>,
}

/// A kind that did not run.
#[derive(Debug, Serialize)]
pub struct SkippedKind {
    /// Its name.
    pub kind: String,
    /// Why.
    pub why: String,
}

/// A kind on its own.
#[derive(Debug, Serialize)]
pub struct KindFigures {
    /// Its name.
    pub kind: String,
    /// Its passes.
    pub passes: usize,
    /// Whether other nodes make its inputs or show its result. Then times are those of its own passes, which do not
    /// overlap, and else those of the frame.
    pub with_others: bool,
    /// Parameters that are not at their defaults, because the kind changes nothing with these.
    pub set: Vec<String>,
    /// The figures at each size.
    pub sizes: Vec<SizeFigures>,
}

impl KindFigures {
    pub(super) fn new(kind: &str) -> Self {
        Self { kind: kind.to_owned(), passes: 0, with_others: false, set: Vec::new(), sizes: Vec::new() }
    }
}

/// A kind at one size.
#[derive(Debug, Serialize)]
pub struct SizeFigures {
    /// Width and height of a frame.
    pub size: [u32; 2],
    /// Milliseconds.
    pub ms: f64,
    /// Bytes of its inputs and of its result.
    pub least_bytes: u64,
    /// These per time, as a share of the copy bandwidth.
    pub share: f64,
    /// Bytes that its passes read and write, images between them included.
    pub moved_bytes: u64,
    /// These per time, as a share of the copy bandwidth.
    pub moved_share: f64,
    /// The same work written by hand, for kinds that have a baseline.
    pub baseline: Option<BaselineFigures>,
}

/// A baseline.
#[derive(Debug, Serialize)]
pub struct BaselineFigures {
    /// Its milliseconds.
    pub ms: f64,
    /// The mean difference of a channel from the kind's result. Both are compressed to x / (1 + x), from 0 to 1.
    pub mean_difference: f64,
    /// The largest one.
    pub max_difference: f64,
    /// The mean difference of the kind's result from its source: what the kind does.
    pub effect: f64,
}

/// The mean and the largest difference of a color channel of light.
pub(super) fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> (f64, f64) {
    let compressed = |x: f32| f64::from(x.max(0.0)) / (1.0 + f64::from(x.max(0.0)));
    let channels = a.iter().zip(b).flat_map(|(a, b)| [0, 1, 2].map(|c| (compressed(a[c]) - compressed(b[c])).abs()));
    let (sum, largest) = channels.fold((0.0, 0.0_f64), |(sum, largest), off| (sum + off, largest.max(off)));
    (sum / (3 * a.len().max(1)) as f64, largest)
}

impl KindsReport {
    fn sizes(&self) -> Vec<[u32; 2]> {
        let mut sizes: Vec<[u32; 2]> =
            self.kinds.iter().flat_map(|row| &row.sizes).map(|figures| figures.size).collect();
        sizes.sort_unstable();
        sizes.dedup();
        sizes
    }

    fn write_kinds(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sizes = self.sizes();
        let mut header = vec!["kind".to_owned(), "passes".to_owned()];
        for [width, height] in &sizes {
            header.extend([format!("{width}x{height}, ms"), "MB".into(), "of copy".into(), "moved, of copy".into()]);
        }
        let row = |row: &KindFigures| {
            let mark = if row.with_others { " (own passes)" } else { "" };
            let mut cells = vec![format!("`{}`{mark}", row.kind), row.passes.to_string()];
            for size in &sizes {
                match row.sizes.iter().find(|figures| figures.size == *size) {
                    Some(SizeFigures { ms, least_bytes, share, moved_share, .. }) => cells.extend([
                        format!("{ms:.4}"),
                        megabytes(*least_bytes),
                        percent(*share),
                        percent(*moved_share),
                    ]),
                    None => cells.extend([const { String::new() }; 4]),
                }
            }
            cells
        };
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        writeln!(f, "{}", table(&header, self.kinds.iter().map(row)))
    }

    fn write_baselines(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = self.kinds.iter().flat_map(|row| row.sizes.iter().map(move |figures| (row, figures)));
        let row = |(row, figures): (&KindFigures, &SizeFigures)| {
            let BaselineFigures { ms, mean_difference, max_difference, effect } = figures.baseline.as_ref()?;
            let [width, height] = figures.size;
            Some(vec![
                format!("`{}` at {width}x{height}", row.kind),
                format!("{:.4}", figures.ms),
                format!("{ms:.4}"),
                format!("{:.2}", figures.ms / ms),
                format!("{mean_difference:.5}"),
                format!("{max_difference:.4}"),
                format!("{effect:.5}"),
            ])
        };
        let header = ["kind", "ms", "baseline, ms", "kind / baseline", "mean difference", "largest", "effect"];
        let rows: Vec<_> = rows.filter_map(row).collect();
        if rows.is_empty() { Ok(()) } else { writeln!(f, "\n{}", table(&header, rows)) }
    }
}

impl fmt::Display for KindsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clock = if self.clock == "gpu" { "GPU time" } else { "the host's clock" };
        writeln!(f, "{} ({}), {clock}, medians of {} frames", self.adapter, self.driver, self.frames)?;
        writeln!(f, "copy bandwidth {:.0} GB/s\n", self.copy_gbps)?;
        self.write_kinds(f)?;
        self.write_baselines(f)?;
        writeln!(f)?;
        for row in self.kinds.iter().filter(|row| !row.set.is_empty()) {
            writeln!(f, "* `{}` with {}, because its defaults change nothing", row.kind, row.set.join(", "))?;
        }
        for SkippedKind { kind, why } in &self.skipped {
            writeln!(f, "* `{kind}` is not measured: {why}")?;
        }
        Ok(())
    }
}
