//! `afterimage bench`: what it measures is there, agrees with itself, and is remembered.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Params as _};
use afterimage_lab::bench::{KindsOptions, KindsReport, kinds};
use afterimage_lab::stress;
use afterimage_nodes::DemoScene;
use afterimage_plan::Options;
use serde_json::Value;

use crate::support::gpu::gpu;

/// A folder of one test with a cache of its own, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("afterimage-bench-{}-{test}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn bench(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage-under-test"));
        command.arg("bench").args(arguments).current_dir(&self.0).env("XDG_CACHE_HOME", self.0.join("cache"));
        command.output().unwrap()
    }

    /// The figures of a built-in pipeline, as JSON.
    fn figures(&self, pipeline: &str, size: &str, arguments: &[&str]) -> Value {
        let pipeline = built_in(pipeline);
        let pipeline = pipeline.to_string_lossy();
        let small = ["--size", size, "--frames", "3", "--json", "figures.json"];
        let output = self.bench(&[&[pipeline.as_ref()], small.as_slice(), arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&fs::read(self.0.join("figures.json")).unwrap()).unwrap()
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
    let figures = folder.figures("lynx", SMALL, &[]);
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
fn the_baseline_looks_like_its_pipeline_and_is_reported_beside_no_other() {
    let folder = Folder::new("baseline");
    // The baseline has the curve as published.
    let sets = ["mapped.space=Rec709", "mapped.middle_gray=Native", "mapped.keep_hue=0.0", "mapped.gamut=Clip"];
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    let baseline = folder.figures("lynx", "320x180", &sets)["baseline"].clone();
    for key in ["fragment_ms", "compute_ms"] {
        assert!(number(&baseline[key]) > 0.0 && number(&baseline["same"][key]) > 0.0, "{key}: {baseline}");
    }
    // With the same filters, weights and noise only roundings and the noise at black and white are left: far below one code of 255.
    assert!(number(&baseline["same"]["mean_difference"]) < 0.001, "{baseline}");
    // Its light comes from half the pixels' means, so bright edges differ; a chain that is wired wrongly is off by far more on average.
    assert!(number(&baseline["mean_difference"]) < 0.03, "{baseline}");
    assert!(folder.figures("lynx", SMALL, &[])["baseline"].is_null());
    assert!(folder.figures("caracal", SMALL, &[])["baseline"].is_null());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_calibration_is_remembered() {
    let folder = Folder::new("calibrate");
    let output = folder.bench(&["--calibrate", "--frames", "1"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let [file] = folder.remembered("calibration.json").try_into().unwrap();
    let all: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    let adapters: Vec<&Value> = all.as_object().unwrap().values().collect();
    assert_eq!(adapters.len(), 1, "{all}");
    let halves = &adapters[0]["formats"]["Rgba16Float"];
    assert!(number(&halves["compute_ms"]) > 0.0 && number(&halves["fragment_ms"]) > 0.0, "{all}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_damaged_store_of_pipelines_is_replaced() {
    let folder = Folder::new("pipelines");
    folder.figures("lynx", SMALL, &[]);
    // Only Vulkan has such a store.
    let Some(file) = folder.remembered(".pipelines").pop() else { return };
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

/// The figures of these kinds on their own.
fn kinds_alone(names: &[&str], size: Size) -> KindsReport {
    let gpu = gpu();
    let registry = stress::registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let tables: Vec<&[NodeKind]> =
        names.iter().map(|name| std::slice::from_ref(registry.get(name).expect("a built-in kind"))).collect();
    let scene = |graph: &afterimage_graph::check::Graph, size| {
        let node = graph.nodes.iter().find(|node| node.kind().name() == DemoScene::KIND)?;
        Some(DemoScene::from_values(node.instance.values())?.camera(size))
    };
    let options = KindsOptions { sizes: vec![size], samples: 1, options: Options::default(), camera: &scene };
    kinds(&gpu, &registry, &tables, &options, &()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_baselines_of_kinds_have_the_pictures_of_the_kinds() {
    // In a smaller image hardly a circle is larger than a pixel.
    let lens = kinds_alone(&["DepthOfField"], Size::new(960, 540));
    let others = kinds_alone(&["Gtao", "Taa"], Size::new(480, 270));
    assert_eq!((lens.kinds.len(), others.kinds.len()), (1, 2));
    let rows = [(&lens, &lens.kinds[0]), (&others, &others.kinds[0]), (&others, &others.kinds[1])];
    for (report, row) in rows {
        let baseline = row.sizes[0].baseline.as_ref().unwrap_or_else(|| panic!("`{}` has no baseline", row.kind));
        // Both results are half floats, which differ by one unit where roundings differ: by 2^-11 of the light, which
        // the compression takes to at most 2^-13. Intermediate images round once more.
        let rounding = 2.0_f64.powi(-12);
        assert!(baseline.mean_difference < rounding, "{report}");
        // The kind does far more than that, so a baseline that does less fails: without one of the two means of `Gtao`
        // they differ by 0.0013, without the limit of the history of `Taa` by 0.0029.
        assert!(baseline.effect > 8.0 * rounding, "{report}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_read_and_write_at_least_their_images() {
    let report = kinds_alone(&["Saturation", "Upsample", "Gaussian", "Resolve", "Fog"], Size::new(64, 32));
    assert!(report.skipped.is_empty() && report.kinds.len() == 5, "{report}");
    let halves = 64 * 32 * 8;
    let figures = |kind: &str| {
        let row = report.kinds.iter().find(|row| row.kind == kind).unwrap_or_else(|| panic!("{report}"));
        (row, &row.sizes[0])
    };
    for (kind, bytes) in [
        ("Saturation", 2 * halves),
        ("Gaussian", 2 * halves),
        // Four samples.
        ("Resolve", 5 * halves),
        // The depth has one float.
        ("Fog", 2 * halves + halves / 2),
    ] {
        let (row, figures) = figures(kind);
        assert_eq!((figures.least_bytes, row.with_others), (bytes, false), "{kind}: {report}");
        assert!(figures.moved_bytes >= bytes && figures.ms > 0.0, "{kind}: {report}");
    }
    // Between its two passes.
    assert_eq!(figures("Gaussian").1.moved_bytes, 4 * halves);
    // Its pyramid has a maker, and begins with half of the image.
    let (row, figures) = figures("Upsample");
    assert!(row.with_others && figures.least_bytes < halves, "{report}");
    assert_eq!(report.kinds[0].set, ["amount=1.5"]);
}
