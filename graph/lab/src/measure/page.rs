//! A page of documentation with the figures of many pipelines and adapters.
//!
//! Each adapter has a file of figures in the folder. The page is written from all of these files, so a measurement on
//! another adapter adds a column.

use std::path::{Path, PathBuf};

use afterimage_media::{read_text, write_atomic};
use serde_json::{Value, json};

use super::chart::write_chart;
use super::json::json as report_json;
use super::report::MeasureReport;
use super::table::significant;
use crate::LabError;
use crate::files::{MAX_TEXT, has_extension, make_folder};

const HEADING: &str = "\
# Tiers and switches, measured

Made by `afterimage measure PIPELINES IMAGE... --docs DIR`. A run on another adapter adds a column to the tables.

Errors are differences from the reference, the same pipeline with f32 intermediates and every quality switch at its most
accurate, before dither and quantization: the worst over all images, in 8-bit codes. p99.9 is the error that one pixel
in a thousand exceeds; FLIP is the difference that a viewer sees when the images alternate, from 0 to 1; dE2000 is the
mean color difference, 1 is just noticeable. Times are medians of one frame of the largest image; MiB is the memory of
transient images. A dot marks the variants that no other one beats in both time and error.
";

/// A folder with the figures of adapters and the page about them.
pub struct FigurePage {
    folder: PathBuf,
    /// The file of this adapter, without its extension.
    adapter: String,
    pipelines: Vec<Value>,
}

impl FigurePage {
    /// Opens the folder, with the figures that it has of this adapter.
    ///
    /// # Errors
    /// The folder cannot be made, or its files cannot be read.
    pub fn open(folder: &Path, adapter: &str) -> Result<Self, LabError> {
        make_folder(folder)?;
        let adapter = file_name(adapter);
        let file = folder.join(format!("{adapter}.json"));
        let pipelines = if file.exists() { read(&file)?.pipelines } else { Vec::new() };
        Ok(Self { folder: folder.to_owned(), adapter, pipelines })
    }

    /// Adds the figures of a pipeline, and its chart if there are figures of switches. The files are written at once,
    /// so that an interruption loses one pipeline.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add(&mut self, name: &str, report: &MeasureReport) -> Result<(), LabError> {
        if report.rows.iter().any(|row| row.kind.is_switch()) {
            write_chart(&self.folder.join(format!("{name}-{}.svg", self.adapter)), report)?;
        }
        self.pipelines.retain(|pipeline| pipeline["pipeline"] != name);
        self.pipelines.push(of_report(report, name));
        self.pipelines.sort_by_key(|pipeline| pipeline["pipeline"].as_str().unwrap_or_default().to_owned());
        let file = self.folder.join(format!("{}.json", self.adapter));
        Ok(write_atomic(&file, text(&self.pipelines).as_bytes())?)
    }

    /// Writes `README.md` from the figures of all adapters in the folder.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn write(&self) -> Result<(), LabError> {
        Ok(write_atomic(&self.folder.join("README.md"), page(&self.folder)?.as_bytes())?)
    }
}

/// The files of a folder with this extension, in the order of their names.
fn files(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, LabError> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| LabError::request(format!("cannot read the folder `{}`: {error}", folder.display())))?;
    let mut all: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    all.retain(|path| has_extension(path, extension));
    all.sort();
    Ok(all)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The name of an adapter as a file name, without what is in brackets.
fn file_name(adapter: &str) -> String {
    let name = adapter.split('(').next().unwrap_or_default().trim().to_lowercase();
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect()
}

/// One pipeline's figures, the worst over the images.
fn of_report(report: &MeasureReport, name: &str) -> Value {
    let mut all = report_json(report);
    let mut rows = all["rows"].take();
    for (row, value) in report.rows.iter().zip(rows.as_array_mut().into_iter().flatten()) {
        if let Some(object) = value.as_object_mut() {
            object.remove("images");
            object.remove("clock");
            object.insert("worst_on".into(), json!(report.clips[row.worst_clip()].name));
        }
    }
    json!({
        "pipeline": name,
        "adapter": report.adapter,
        "clock": report.clock.name(),
        "images": all["images"],
        "rows": rows,
    })
}

/// The figures of several pipelines, each row on one line.
fn text(pipelines: &[Value]) -> String {
    let one = |pipeline: &Value| {
        let lines: Vec<String> = rows(pipeline).iter().map(|row| format!("      {row}")).collect();
        let fields = ["pipeline", "adapter", "clock", "images"].map(|name| format!("    {name:?}: {}", pipeline[name]));
        format!("  {{\n{},\n    \"rows\": [\n{}\n    ]\n  }}", fields.join(",\n"), lines.join(",\n"))
    };
    format!("[\n{}\n]\n", pipelines.iter().map(one).collect::<Vec<_>>().join(",\n"))
}

/// The content of one adapter's file.
struct Figures {
    /// The file without its ending.
    name: String,
    pipelines: Vec<Value>,
}

fn read(path: &Path) -> Result<Figures, LabError> {
    let text = read_text(path, MAX_TEXT)?;
    let pipelines = serde_json::from_str(&text)
        .map_err(|error| LabError::request(format!("`{}` holds no figures: {error}", path.display())))?;
    Ok(Figures { name: stem(path), pipelines })
}

impl Figures {
    fn pipeline(&self, name: &str) -> Option<&Value> {
        self.pipelines.iter().find(|pipeline| pipeline["pipeline"] == name)
    }

    fn row(&self, pipeline: &str, variant: &str) -> Option<&Value> {
        rows(self.pipeline(pipeline)?).iter().find(|row| row["variant"] == variant)
    }

    /// `GPU ms on NVIDIA H200, 2560x1440`.
    fn heading(&self) -> String {
        let Some(first) = self.pipelines.first() else { return self.name.clone() };
        let size = |image: &&Value| image["width"].as_u64().unwrap_or(0) * image["height"].as_u64().unwrap_or(0);
        let largest = first["images"].as_array().and_then(|images| images.iter().max_by_key(size));
        let size = largest.map_or(String::new(), |image| format!(", {}x{}", image["width"], image["height"]));
        let clock = if first["clock"] == "gpu" { "GPU" } else { "host" };
        let adapter = first["adapter"].as_str().unwrap_or_default();
        format!("{clock} ms on {}{size}", adapter.split(" (").next().unwrap_or_default())
    }
}

fn rows(pipeline: &Value) -> &[Value] {
    pipeline["rows"].as_array().map_or(&[], Vec::as_slice)
}

/// The page, from the figures of all adapters in the folder. GPUs come first: the errors and the switches are theirs.
fn page(folder: &Path) -> Result<String, LabError> {
    let mut all = files(folder, "json")?.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    all.sort_by_key(|figures| figures.pipelines.iter().any(|pipeline| pipeline["clock"] == "host"));
    let Some(first) = all.first() else { return Ok(HEADING.to_owned()) };
    let mut text = format!("{HEADING}\n## Tiers\n\n{}", tier_table(first, &all));
    for pipeline in first.pipelines.iter().filter(|pipeline| rows(pipeline).iter().any(is_switch)) {
        let name = pipeline["pipeline"].as_str().unwrap_or_default();
        let plot = format!("{name}-{}.svg", first.name);
        text += &format!("\n## {name}\n\n{}\n\n![Time against error]({plot})\n\n{}", images(pipeline), table(pipeline));
    }
    Ok(text)
}

fn is_switch(row: &Value) -> bool {
    row["kind"] == "switch" || row["kind"] == "format"
}

fn images(pipeline: &Value) -> String {
    let one = |image: &Value| {
        format!("{} {}x{}", image["image"].as_str().unwrap_or_default(), image["width"], image["height"])
    };
    let all: Vec<String> = pipeline["images"].as_array().into_iter().flatten().map(one).collect();
    format!("On {} images: {}.", all.len(), all.join(", "))
}

fn tier_table(first: &Figures, all: &[Figures]) -> String {
    let headings: Vec<String> = all.iter().map(Figures::heading).collect();
    let mut text = format!(
        "| pipeline | tier | {} | MiB | p99.9 | max | PSNR | SSIM | dE2000 | FLIP | worst on |\n\
         |---|---{}|--:|--:|--:|--:|--:|--:|--:|---|\n",
        headings.join(" | "),
        "|--:".repeat(all.len())
    );
    for pipeline in &first.pipelines {
        let name = pipeline["pipeline"].as_str().unwrap_or_default();
        for row in rows(pipeline).iter().filter(|row| row["kind"] == "tier" || row["kind"] == "written") {
            let variant = row["variant"].as_str().unwrap_or_default();
            let times: Vec<String> = all
                .iter()
                .map(|figures| figures.row(name, variant).map_or("-".into(), |row| number(row, "gpu_ms")))
                .collect();
            let tier = variant.trim_start_matches("tier ");
            text += &format!("| {name} | {tier} | {} | {} |\n", times.join(" | "), errors(row));
        }
    }
    text
}

/// Every variant of one pipeline on the first adapter.
fn table(pipeline: &Value) -> String {
    let mut text = "| | variant | ms | MiB | p99.9 | max | PSNR | SSIM | dE2000 | FLIP | worst on |\n\
                    |---|---|--:|--:|--:|--:|--:|--:|--:|--:|---|\n"
        .to_owned();
    for row in rows(pipeline) {
        let mark = if row["pareto"] == true { "●" } else { "" };
        let variant = row["variant"].as_str().unwrap_or_default();
        text += &format!("| {mark} | {variant} | {} | {} |\n", number(row, "gpu_ms"), errors(row));
    }
    text
}

fn errors(row: &Value) -> String {
    let mebibytes = row["bytes"].as_f64().unwrap_or(0.0) / f64::from(1 << 20);
    let psnr = row["psnr"].as_f64().map_or("equal".to_owned(), |psnr| format!("{psnr:.1}"));
    let ssim = row["ssim"].as_f64().map_or("-".to_owned(), |ssim| format!("{ssim:.5}"));
    let worst = row["worst_on"].as_str().unwrap_or_default();
    let [p999, max, color, flip] = ["p999", "max", "ciede2000_mean", "flip"].map(|name| number(row, name));
    format!("{mebibytes:.1} | {p999} | {max} | {psnr} | {ssim} | {color} | {flip} | {worst}")
}

fn number(row: &Value, name: &str) -> String {
    row[name].as_f64().map_or("-".to_owned(), significant)
}
