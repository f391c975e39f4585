//! The report as comma-separated values (RFC 4180).

use super::judge::Figures;
use super::report::{Report, Row};

/// What stands for an image in the lines that hold the worst over all.
const WORST: &str = "worst";

/// One line for each variant and image, and one for its worst; an infinite number is `inf`, one that there is not is empty.
pub(crate) fn csv(report: &Report) -> String {
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

fn line(report: &Report, row: &Row, image: &str, figures: &Figures) -> String {
    let cost = figures.cost;
    let mut fields = vec![
        quoted(&row.variant),
        row.kind.name().to_owned(),
        row.pareto.to_string(),
        quoted(image),
        report.watch.name().to_owned(),
        cost.ms.to_string(),
        cost.bytes.to_string(),
        cost.moved.to_string(),
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
