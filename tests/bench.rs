//! `afterimage bench`: what it measures is there, agrees with itself, and is remembered.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use afterimage_gpu::wgpu;
use serde_json::Value;

use crate::support::command::program;
use crate::support::gpu::gpu;
use crate::support::numbers::is_rounded;

/// A folder of one test with a cache of its own, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("afterimage-bench-{}-{test}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn bench(&self, arguments: &[&str]) -> Output {
        let mut command = program(&self.0.join("cache"));
        command.arg("bench").args(arguments).current_dir(&self.0);
        command.output().unwrap()
    }

    /// The figures of a built-in pipeline, as JSON.
    fn figures(&self, pipeline: &str, size: &str, arguments: &[&str]) -> Value {
        let pipeline = built_in(pipeline);
        let pipeline = pipeline.to_string_lossy();
        let small = ["--size", size, "--frames", "3", "--json", "figures.json"];
        let output = self.bench(&[&[pipeline.as_ref()], small.as_slice(), arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let figures = serde_json::from_slice(&fs::read(self.0.join("figures.json")).unwrap()).unwrap();
        printed(&String::from_utf8_lossy(&output.stdout), &figures);
        figures
    }

    fn remembered(&self, ending: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.0.join("cache/afterimage")).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.to_string_lossy().ends_with(ending)).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// That the text has the figures of the file, in its own units.
fn printed(text: &str, figures: &Value) {
    let line = |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{text}"));
    let agree = |line: &str, numbers: &[f64]| {
        let words = line.split([' ', '(', '|']).filter(|word| word.parse::<f64>().is_ok());
        let words: Vec<&str> = words.collect();
        let is_it = words.len() == numbers.len() && words.iter().zip(numbers).all(|(word, n)| is_rounded(word, *n));
        assert!(is_it, "{line} is not {numbers:?}");
    };
    let of = |path: &str| number(figures.pointer(path).unwrap_or_else(|| panic!("{path}: {figures}")));
    let (mega, share) = (1e-6, 100.0 * of("/share"));
    let clock = if figures["clock"] == "gpu" { "GPU, a frame" } else { "host clock, a frame" };
    agree(line(clock), &[of("/gpu_ms"), of("/gpu_ms_interval/0"), of("/gpu_ms_interval/1"), 95.0, share]);
    agree(line("host, a frame"), &[of("/host/record_us"), of("/host/finish_us"), of("/host/submit_us")]);
    agree(line("copy bandwidth"), &[of("/copy_gbps")]);
    agree(line("memory"), &[mega * of("/memory/transient"), mega * of("/memory/kept")]);
    agree(line("text to first frame"), &[of("/first_frame_ms/cold"), of("/first_frame_ms/warm")]);
    let passes = figures["passes"].as_array().unwrap();
    let mut sum = 0.0;
    for (pass, line) in passes.iter().zip(text.lines().skip(3)) {
        let (name, rest) = line.trim_start_matches("| ").split_once(" | ").unwrap();
        let label = name.trim_end().trim_end_matches(" (after a change)").trim_end_matches(" (drawn)");
        assert_eq!(label, pass["name"]);
        assert_eq!(name.contains("(drawn)"), pass["stage"] == "fragment", "{line}");
        agree(rest, &[number(&pass["ms"]), mega * number(&pass["bytes"]), 100.0 * number(&pass["share"])]);
        sum += if pass["runs_on_change"] == true { 0.0 } else { number(&pass["ms"]) };
    }
    agree(line("| sum, without overlap"), &[sum, mega * of("/bytes")]);
}

const SMALL: &str = "96x64";

fn built_in(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../pipelines").join(format!("{name}.ron"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_figure_is_there_and_agrees_with_the_others() {
    let folder = Folder::new("figures");
    // The passes that fill a table are listed, and are no part of each frame.
    let figures = folder.figures("lynx", SMALL, &["--plan", "bake=Off"]);
    for key in ["gpu_ms", "host_us", "copy_gbps"] {
        assert!(number(&figures[key]) > 0.0, "{key}: {figures}");
    }
    let passes = figures["passes"].as_array().unwrap();
    let bytes: f64 = passes.iter().map(|pass| number(&pass["bytes"])).sum();
    assert_eq!(bytes, number(&figures["bytes"]));
    // The scene is read and a picture of the same size is written, whatever the passes in between do.
    assert!(bytes >= 96.0 * 64.0 * (8.0 + 4.0), "{bytes} bytes");
    for pass in passes {
        assert!(!pass["name"].as_str().unwrap().is_empty());
        let reached = number(&pass["bytes"]) * 1e-6 / number(&pass["ms"]);
        let share = number(&pass["share"]);
        assert!((reached / number(&figures["copy_gbps"]) - share).abs() <= 1e-9 + 1e-6 * share, "{pass}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_damaged_store_of_pipelines_is_replaced() {
    let folder = Folder::new("pipelines");
    folder.figures("lynx", SMALL, &[]);
    let file = folder.remembered(".pipelines").pop();
    let has_cache = gpu().device.features().contains(wgpu::Features::PIPELINE_CACHE);
    assert_eq!(file.is_some(), has_cache, "a device with a cache of pipelines has a store, and no other one");
    let Some(file) = file else { return };
    let good = fs::read(&file).unwrap();
    fs::write(&file, &good[..good.len() / 2]).unwrap();
    folder.figures("lynx", SMALL, &[]);
    assert!(fs::read(&file).unwrap().len() > good.len() / 2);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_must_be_named() {
    let folder = Folder::new("nothing");
    let output = folder.bench(&[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("<PIPELINE>"));
}
