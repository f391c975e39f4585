//! The report as a text table.

use afterimage_gpu::{ClockSource, FrameTime};
use comfy_table::presets::NOTHING;
use comfy_table::{Attribute, Cell, CellAlignment, Color, Table};

use super::digits::significant;
use super::report::{MeasureReport, Row};
use super::variants::VariantKind;
use super::wires::wires;
use crate::metrics::Range;

/// The table, with a caption above and a legend below.
pub fn table(report: &MeasureReport) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING).enforce_styling();
    table.set_header(headings(report).into_iter().map(|heading| Cell::new(heading).add_attribute(Attribute::Bold)));
    for (at, row) in report.rows.iter().enumerate().filter(|(at, _)| report.same_as(*at).is_none()) {
        let mut names = row.variant.clone();
        for (other, same) in report.rows.iter().enumerate() {
            // The tier of the command line is named already.
            let is_named = names.ends_with(&format!(", {}", same.variant));
            if report.same_as(other) == Some(at) && !is_named {
                names += &format!(", {}", same.variant);
            }
        }
        table.add_row(cells(report, row, names));
    }
    for column in 2..table.column_count() {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let lines: Vec<String> = table.lines().map(|line| line.trim_end().to_owned()).collect();
    format!("{}\n\n{}\n{}", report.caption(), lines.join("\n"), legend(report))
}

fn headings(report: &MeasureReport) -> Vec<&'static str> {
    let time = if report.clock == ClockSource::Gpu { "GPU ms" } else { "host ms" };
    let color = if report.range == Range::Sdr { "dE2000" } else { "dE ITP" };
    let mut headings = vec!["", "variant", time, "MiB", "moved", "max", "p99.9", "PSNR", "SSIM", color, "FLIP", "JOD"];
    if has_flicker(report) {
        headings.push("flicker");
    }
    if report.sequences.len() > 1 {
        headings.extend(["worst on", "without it"]);
    }
    headings
}

fn has_flicker(report: &MeasureReport) -> bool {
    report.rows.iter().any(|row| row.worst().errors.flicker.is_some())
}

fn cells(report: &MeasureReport, row: &Row, names: String) -> Vec<Cell> {
    let worst = row.worst();
    let errors = worst.errors;
    let mebibytes = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let mark = if row.pareto { "●" } else { "" };
    let mut texts = vec![
        mark.to_owned(),
        names,
        time(worst.cost.time),
        mebibytes(worst.cost.bytes),
        mebibytes(worst.cost.bytes_moved),
        significant(errors.max),
        significant(errors.p999),
        if errors.psnr.is_finite() { format!("{:.1}", errors.psnr) } else { "equal".into() },
        format!("{:.5}", errors.ssim),
        significant(errors.color),
        significant(errors.flip),
        format!("{:.2}", errors.jod),
    ];
    if has_flicker(report) {
        texts.push(errors.flicker.map_or(String::new(), |flicker| significant(flicker.p999)));
    }
    if report.sequences.len() > 1 {
        texts.push(report.sequences[row.worst_sequence()].name.clone());
        texts.push(row.p999_without_worst().map_or(String::new(), significant));
    }
    texts.into_iter().map(|text| styled(row, text)).collect()
}

fn styled(row: &Row, text: String) -> Cell {
    let cell = Cell::new(text);
    match (row.kind, row.pareto) {
        (VariantKind::Reference, _) => cell.fg(Color::Cyan),
        (_, true) => cell.fg(Color::Green),
        (_, false) => cell.add_attribute(Attribute::Dim),
    }
}

/// `1 frame`, `8 frames`.
pub(super) fn frames(count: u32) -> String {
    format!("{count} frame{}", if count == 1 { "" } else { "s" })
}

/// The median, and how far from it the interval reaches.
fn time(time: FrameTime) -> String {
    let [least, most] = time.interval();
    let spread = 0.5 * (most - least) / time.ms();
    let median = significant(time.ms());
    if spread > 0.0 { format!("{median} ±{:.0} %", 100.0 * spread) } else { median }
}

fn legend(report: &MeasureReport) -> String {
    let clock = if report.clock == ClockSource::Gpu { "GPU" } else { "host" };
    let time = format!("time on the {clock}, the median of {}", frames(report.samples));
    let mut text = format!(
        "\n● no other variant is as accurate and faster, or as fast and more accurate; errors in {}; JOD on \
         `{}`; {time}",
        report.unit(),
        report.display.name
    );
    if report.sequences.len() > 1 {
        let more = report.sequences.len() + 1;
        text += "\nwithout it: the p99.9 of the other images; ";
        text += &format!("one image more of their kind exceeds the p99.9 of all in 1 of {more} cases");
    }
    for wire in wires(report) {
        text += &format!("\n{wire}");
    }
    if !report.without_effect.is_empty() {
        text += &format!("\nwithout effect here: {}", report.without_effect.join(", "));
    }
    text
}
