//! The report as comma-separated values (RFC 4180).

use super::reference::Figures;
use super::report::{MeasureReport, Row};

/// The name in the image column of lines with the worst over all images.
const WORST: &str = "worst";

/// One line for each variant and image, and one for its worst. Infinite is `inf`, a figure that does not apply is
/// empty.
pub fn csv(report: &MeasureReport) -> String {
    let names = report.rows.first().map(|row| row.worst().errors.named(report.range).map(|(name, _)| name));
    let mut columns = vec!["variant", "kind", "pareto", "image", "clock", "gpu_ms", "bytes", "bytes_moved", "passes"];
    columns.extend(names.into_iter().flatten());
    let mut text = columns.join(",") + "\r\n";
    for row in &report.rows {
        text += &line(report, row, WORST, &row.worst());
        for (clip, figures) in report.clips.iter().zip(&row.clips) {
            text += &line(report, row, &clip.name, figures);
        }
    }
    text
}

fn line(report: &MeasureReport, row: &Row, image: &str, figures: &Figures) -> String {
    let cost = figures.cost;
    let mut fields = vec![
        quoted(&row.variant),
        row.kind.name().to_owned(),
        row.pareto.to_string(),
        quoted(image),
        report.clock.name().to_owned(),
        cost.time.ms().to_string(),
        cost.bytes.to_string(),
        cost.bytes_moved.to_string(),
        cost.passes.to_string(),
    ];
    fields.extend(figures.errors.named(report.range).map(|(name, value)| match value {
        Some(value) => value.to_string(),
        None if name == "psnr" => "inf".to_owned(),
        None => String::new(),
    }));
    fields.join(",") + "\r\n"
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
