//! `measure --docs`: figures of many pipelines and adapters as a page of the manual.
//!
//! Each adapter has a file of figures in the folder. The page is made anew from all of them, so whoever measures adds a column.

use std::path::{Path, PathBuf};

use afterimage_gpu::Gpu;
use afterimage_graph::node::Registry;
use serde_json::{Value, json};

use super::args::MeasureArgs;
use super::report::Report;
use super::table::significant;
use super::{json, plot, report};
use crate::failure::Failure;
use crate::terminal::note;
use afterimage_media::write_atomic;

const HEADING: &str = "\
# Tiers and switches, measured

Made by `afterimage measure PIPELINES IMAGE... --docs DIR`; run it again on another adapter and the tables get another column.

Errors are against the truth, the same pipeline in 32 bits with every switch at its most exact, before dither and rounding: the worst over
all images, in codes of 8 bits. p99.9 is what one pixel in a thousand exceeds; FLIP is what a viewer sees when the pictures alternate,
from 0 to 1; dE2000 is the mean colour difference, 1 is just noticeable. Times are medians of one frame, of the largest image; MiB is what
images between passes hold at once. A dot marks what nothing else beats in both time and error.
";

/// Measures every pipeline and writes the adapter's figures, its plots and the page.
pub(super) fn write(folder: &Path, args: &MeasureArgs, gpu: &Gpu, registry: &Registry) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", folder.display())))?;
    let adapter = file_name(&gpu.name());
    let file = folder.join(format!("{adapter}.json"));
    let mut known = if file.exists() { read(&file)?.pipelines } else { Vec::new() };
    for path in pipelines(&args.pipeline)? {
        note(&path.to_string_lossy());
        let report = report(args, &path, gpu, registry)?;
        if !args.tiers {
            plot::write(&folder.join(format!("{}-{adapter}.svg", stem(&path))), &report)?;
        }
        let name = stem(&path);
        known.retain(|pipeline| pipeline["pipeline"] != name.as_str());
        known.push(of_report(&report, &name));
        known.sort_by_key(|pipeline| pipeline["pipeline"].as_str().unwrap_or_default().to_owned());
        // After each pipeline, so that an interruption loses one.
        write_atomic(&file, text(&known).as_bytes())?;
    }
    Ok(write_atomic(&folder.join("README.md"), page(folder)?.as_bytes())?)
}

/// The pipelines of a folder, in the order of their names; or the file itself.
fn pipelines(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let all = files(path, "ron")?;
    if all.is_empty() {
        return Err(Failure::user(format!("no file in `{}` ends in `.ron`", path.display())));
    }
    Ok(all)
}

fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Failure> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| Failure::user(format!("cannot read the folder `{}`: {error}", folder.display())))?;
    let mut all: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    all.retain(|path| super::ends_with(path, ending));
    all.sort();
    Ok(all)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The name of an adapter as that of a file: what stands in brackets is left out.
fn file_name(adapter: &str) -> String {
    let name = adapter.split('(').next().unwrap_or_default().trim().to_lowercase();
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect()
}

/// One pipeline's figures, the worst over the images.
fn of_report(report: &Report, name: &str) -> Value {
    let mut all = json::json(report);
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
        "clock": report.watch.name(),
        "images": all["images"],
        "rows": rows,
    })
}

/// The figures of several pipelines, a row a line.
fn text(pipelines: &[Value]) -> String {
    let one = |pipeline: &Value| {
        let lines: Vec<String> = rows(pipeline).iter().map(|row| format!("      {row}")).collect();
        let fields = ["pipeline", "adapter", "clock", "images"].map(|name| format!("    {name:?}: {}", pipeline[name]));
        format!("  {{\n{},\n    \"rows\": [\n{}\n    ]\n  }}", fields.join(",\n"), lines.join(",\n"))
    };
    format!("[\n{}\n]\n", pipelines.iter().map(one).collect::<Vec<_>>().join(",\n"))
}

/// What one adapter's file says.
struct Figures {
    /// The file without its ending.
    name: String,
    pipelines: Vec<Value>,
}

fn read(path: &Path) -> Result<Figures, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::user(format!("cannot read the figures `{}`: {error}", path.display())))?;
    let pipelines = serde_json::from_str(&text)
        .map_err(|error| Failure::user(format!("`{}` holds no figures: {error}", path.display())))?;
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

/// The page, from the figures of all adapters in the folder. Real graphics hardware comes first: errors and switches are its.
fn page(folder: &Path) -> Result<String, Failure> {
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
        "| pipeline | tier | {} | MiB | p99.9 | max | PSNR | SSIM | dE2000 | FLIP | worst on |\n|---|---{}|--:|--:|--:|--:|--:|--:|--:|---|\n",
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
    let mut text = "| | variant | ms | MiB | p99.9 | max | PSNR | SSIM | dE2000 | FLIP | worst on |\n|---|---|--:|--:|--:|--:|--:|--:|--:|--:|---|\n".to_owned();
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
    let [p999, max, colour, flip] = ["p999", "max", "ciede2000_mean", "flip"].map(|name| number(row, name));
    format!("{mebibytes:.1} | {p999} | {max} | {psnr} | {ssim} | {colour} | {flip} | {worst}")
}

fn number(row: &Value, name: &str) -> String {
    row[name].as_f64().map_or("-".to_owned(), significant)
}
