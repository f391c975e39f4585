//! The report as JSON.

use serde_json::{Map, Value, json};

use super::reference::Figures;
use super::report::{MeasureReport, SequenceInfo};

/// The whole report. An infinite number, such as the PSNR of equal images, is `null`.
pub fn json(report: &MeasureReport) -> Value {
    let sequences: Vec<Value> = report
        .sequences
        .iter()
        .map(|SequenceInfo { name, width, height, frames, .. }| {
            json!({ "image": name, "width": width, "height": height, "frames": frames })
        })
        .collect();
    json!({
        "pipeline": report.pipeline,
        "output": report.output,
        "adapter": report.adapter,
        "clock": report.clock.name(),
        "repeats": report.samples,
        "error_unit": report.unit(),
        "display": report.display.name,
        "images": sequences,
        "without_effect": report.without_effect,
        "rows": (0..report.rows.len()).map(|at| json_row(report, at)).collect::<Vec<Value>>(),
    })
}

fn json_row(report: &MeasureReport, at: usize) -> Value {
    let row = &report.rows[at];
    let mut object = Map::new();
    object.insert("variant".into(), json!(row.variant));
    object.insert("kind".into(), json!(row.kind.name()));
    object.insert("pareto".into(), json!(row.pareto));
    object.insert("clock".into(), json!(report.clock.name()));
    object.insert("same_as".into(), json!(report.same_as(at).map(|first| &report.rows[first].variant)));
    object.extend(figures(report, &row.worst()));
    if let Some(others) = row.p999_without_worst() {
        object.insert("worst_image".into(), json!(report.sequences[row.worst_sequence()].name));
        object.insert("p999_without_worst".into(), json!(others));
    }
    let image = |(sequence, of_sequence): (&SequenceInfo, &Figures)| {
        let mut object = Map::from_iter([("image".to_owned(), json!(sequence.name))]);
        object.extend(figures(report, of_sequence));
        Value::Object(object)
    };
    let images: Vec<Value> = report.sequences.iter().zip(&row.sequences).map(image).collect();
    object.insert("images".into(), json!(images));
    Value::Object(object)
}

fn figures(report: &MeasureReport, figures: &Figures) -> Map<String, Value> {
    let cost = figures.cost;
    let mut object = Map::new();
    object.insert("gpu_ms".into(), json!(cost.time.ms()));
    object.insert("gpu_ms_interval".into(), json!(cost.time.interval()));
    object.insert("bytes".into(), json!(cost.bytes));
    object.insert("bytes_moved".into(), json!(cost.bytes_moved));
    object.insert("passes".into(), json!(cost.passes));
    for (name, value) in figures.errors.named(report.range) {
        object.insert(name.into(), json!(value));
    }
    object
}
