//! Time against error: a dot for each variant, and a step line through the Pareto-optimal ones.

use std::path::Path;

use afterimage_gpu::ClockSource;

use super::digits::significant;
use super::report::{MeasureReport, Row};
use super::table::frames;
use super::variants::VariantKind;
use crate::plot::axis::{LinearAxis, LogAxis};
use crate::plot::labels::Labels;
use crate::plot::palette::{BLUE, GREEN, GRID, INK, ORANGE, SOFT};
use crate::plot::svg::{Anchor, Canvas};

const WIDTH: f64 = 1280.0;
const HEIGHT: f64 = 720.0;
const LEFT: f64 = 110.0;
const RIGHT: f64 = 1230.0;
const TOP: f64 = 150.0;
const BOTTOM: f64 = 610.0;

const FINE_GRID: &str = "#f1f3f5";
/// The line through the Pareto-optimal variants.
const FRONT: &str = GREEN;

/// The color and the name of each kind of variant, in the order of the legend.
const KINDS: [(VariantKind, &str, &str); 5] = [
    (VariantKind::Reference, SOFT, "reference (32 bits, most accurate)"),
    (VariantKind::Written, INK, "as written"),
    (VariantKind::Tier, BLUE, "tier"),
    (VariantKind::Switch, ORANGE, "one switch"),
    (VariantKind::Format, "#138a86", "one format"),
];

struct Chart<'a> {
    report: &'a MeasureReport,
    canvas: Canvas,
    across: LinearAxis,
    up: LogAxis,
}

/// The chart as an SVG file.
pub fn chart(report: &MeasureReport) -> String {
    let points: Vec<(f64, f64)> = report.rows.iter().map(Row::point).collect();
    let (times, errors): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let mut chart = Chart {
        report,
        canvas: Canvas::new(WIDTH, HEIGHT),
        across: LinearAxis::new(&times, LEFT, RIGHT),
        up: LogAxis::new(&errors, BOTTOM, TOP),
    };
    chart.heading();
    chart.grid();
    let steps = chart.steps();
    chart.canvas.path(&steps, FRONT);
    chart.dots();
    chart.names(&steps);
    chart.legend();
    chart.canvas.finish()
}

impl Chart<'_> {
    fn place(&self, row: &Row) -> (f64, f64) {
        let (ms, error) = row.point();
        (self.across.place(ms), self.up.place(error))
    }

    fn heading(&mut self) {
        let file = Path::new(&self.report.pipeline);
        let name = file.file_stem().map_or(self.report.pipeline.clone(), |stem| stem.to_string_lossy().into_owned());
        self.canvas.text((40.0, 56.0), 32.0, Anchor::Start, INK, &format!("{name}: time against error"));
        self.canvas.text((40.0, 86.0), 17.0, Anchor::Start, SOFT, &self.report.caption());
    }

    fn grid(&mut self) {
        for error in self.up.fine_marks() {
            let y = self.up.place(error);
            self.canvas.line((LEFT, y), (RIGHT, y), FINE_GRID, false);
        }
        for (error, text) in self.up.marks() {
            let y = self.up.place(error);
            self.canvas.line((LEFT, y), (RIGHT, y), GRID, false);
            self.canvas.text((LEFT - 12.0, y + 5.0), 15.0, Anchor::End, SOFT, &text);
        }
        let (marks, places) = self.across.marks();
        for ms in marks {
            let x = self.across.place(ms);
            self.canvas.line((x, TOP), (x, BOTTOM), GRID, false);
            self.canvas.text((x, BOTTOM + 24.0), 15.0, Anchor::Middle, SOFT, &format!("{ms:.places$}"));
        }
        self.axis_names();
    }

    fn axis_names(&mut self) {
        let error = format!("error in {}, 99.9th percentile", self.report.unit());
        self.canvas.text((40.0, TOP - 22.0), 16.0, Anchor::Start, INK, &error);
        let time = match self.report.clock {
            ClockSource::Gpu => format!("milliseconds on the GPU, median of {}", frames(self.report.samples)),
            ClockSource::Host => format!("milliseconds on the host, median of {}", frames(self.report.samples)),
        };
        self.canvas.text(((LEFT + RIGHT) / 2.0, BOTTOM + 54.0), 16.0, Anchor::Middle, INK, &time);
    }

    /// The smallest error within each time: the corners of a step line.
    fn steps(&self) -> Vec<(f64, f64)> {
        let mut best: Vec<(f64, f64)> =
            self.report.rows.iter().filter(|row| row.pareto).map(|row| self.place(row)).collect();
        best.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let Some(first) = best.first() else { return Vec::new() };
        let mut steps = vec![(first.0, TOP), *first];
        for pair in best.windows(2) {
            steps.push((pair[1].0, pair[0].1));
            steps.push(pair[1]);
        }
        steps.push((RIGHT, steps[steps.len() - 1].1));
        steps
    }

    fn dots(&mut self) {
        // The best variants are drawn last, on top of the others.
        let (best, others): (Vec<&Row>, Vec<&Row>) = self.report.rows.iter().partition(|row| row.pareto);
        for row in others.into_iter().chain(best) {
            let (ms, error) = row.point();
            let hint =
                format!("{}: {} ms, {} {}", row.variant, significant(ms), significant(error), self.report.unit());
            let color = color(row.kind);
            let (radius, fill) = if row.pareto { (7.0, color) } else { (4.5, "#ffffff") };
            self.canvas.dot(self.place(row), radius, fill, Some(color), &hint);
        }
    }

    /// Names of the best variants, then of the others where there is space.
    fn names(&mut self, steps: &[(f64, f64)]) {
        let dots: Vec<(f64, f64)> = self.report.rows.iter().map(|row| self.place(row)).collect();
        let mut labels = Labels::new(&dots, steps, [8.0, TOP - 14.0, WIDTH - 8.0, BOTTOM + 2.0]);
        for (is_best, size, color) in [(true, 16.0, INK), (false, 12.5, SOFT)] {
            for (row, dot) in self.report.rows.iter().zip(&dots).filter(|(row, _)| row.pareto == is_best) {
                if let Some(spot) = labels.place(*dot, size, &row.variant) {
                    self.canvas.text(spot.at, size, spot.anchor, color, &row.variant);
                }
            }
        }
    }

    fn legend(&mut self) {
        let y = HEIGHT - 24.0;
        let mut x = 46.0;
        for (kind, color, name) in KINDS {
            if self.report.rows.iter().any(|row| row.kind == kind) {
                self.canvas.dot((x, y - 5.0), 5.0, color, None, "");
                self.canvas.text((x + 13.0, y), 14.0, Anchor::Start, SOFT, name);
                x += 40.0 + 6.8 * name.chars().count() as f64;
            }
        }
        self.canvas.line((x, y - 5.0), (x + 26.0, y - 5.0), FRONT, false);
        self.canvas.text((x + 34.0, y), 14.0, Anchor::Start, SOFT, "filled: nothing is both faster and more accurate");
    }
}

fn color(kind: VariantKind) -> &'static str {
    KINDS.iter().find(|(known, ..)| *known == kind).map_or(INK, |(_, color, _)| color)
}
