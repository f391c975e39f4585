//! Reports of `render`: the exposure, repaired pixels, inputs without a mask; and cuts.

use afterimage_media::{Encoding, Picture, Pixels, write_image};
use serde_json::Value;

use super::{Folder, save};

const METERED: &str = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"bins\": Histogram(source: \"scene\"), \
                       \"meter\": AutoExposure(histogram: \"bins\", rate_bright: 1.0), \
                       \"lit\": Exposure(source: \"scene\", meter: \"meter\") }, outputs: { \"light\": \"lit\" })";

/// A gray picture with these numbers in its first pixels.
fn gray(light: f32, first: &[[f32; 4]]) -> Picture {
    let mut pixels = vec![[light, light, light, 1.0]; 8 * 6];
    pixels[..first.len()].copy_from_slice(first);
    Picture::new(8, 6, Pixels::Float(pixels.as_flattened().to_vec()))
}

/// The file of `--json`.
fn report(folder: &Folder, json: &str) -> Value {
    let text = std::fs::read_to_string(folder.file(json)).expect("the program wrote it");
    serde_json::from_str(&text).expect("it is JSON")
}

/// A figure of the meter in each frame.
fn metered(report: &Value, figure: &str) -> Vec<f64> {
    let frames = report["frames"].as_array().expect("a list of frames");
    frames.iter().map(|frame| frame["exposure"][0][figure].as_f64().expect("a number")).collect()
}

/// The metered stops of each frame, from the file of `--json`.
fn stops(folder: &Folder, json: &str) -> Vec<f64> {
    metered(&report(folder, json), "stops")
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cut_is_exposed_at_once() {
    let folder = Folder::new("cut");
    for (frame, light) in [(1, 0.25), (2, 16.0), (3, 16.0)] {
        save(&folder.file(&format!("shot.{frame}.exr")), &gray(light, &[]));
    }
    folder.with("meter.ron", METERED.as_bytes());
    let words = folder.run("render meter.ron shot.#.exr -o out.#.exr --json slow.json").notes();
    // The figures that are printed are those of the file.
    let told = report(&folder, "slow.json");
    let [stops_of, ev100] = ["stops", "ev100"].map(|figure| {
        let figures = metered(&told, figure);
        let ends = [f64::min, f64::max].map(|end| figures.iter().copied().reduce(end).expect("frames"));
        format!("{:.2} to {:.2}", ends[0], ends[1])
    });
    assert!(words.contains(&format!("exposure of `meter`: {stops_of} stops, at EV100 {ev100}\n")), "{words}");
    let count = serde_json::json!({ "failed": 0, "good": 3, "repaired": 0, "skipped": 0, "unwritten": 0 });
    assert_eq!((&told["summary"], &told["pipeline"]), (&count, &"meter.ron".into()));
    let seconds = |value: &Value| value["seconds"].as_f64().filter(|seconds| *seconds > 0.0).expect("a time");
    for (number, frame) in (1..).zip(told["frames"].as_array().expect("a list")) {
        assert_eq!((&frame["frame"], &frame["files"][0]), (&number.into(), &format!("out.{number}.exr").into()));
    }
    assert!(told["frames"].as_array().expect("a list").iter().map(seconds).sum::<f64>() < seconds(&told));
    folder.run("render meter.ron shot.#.exr -o out.#.exr --json cut.json --cut 2").good();
    let (slow, cut) = (stops(&folder, "slow.json"), stops(&folder, "cut.json"));
    let settled = 0.18_f64.log2() - 4.0;
    assert!((cut[1] - settled).abs() < 0.05 && (cut[2] - settled).abs() < 0.05, "{cut:?}");
    assert!(slow[0] == cut[0] && slow[1] > settled + 4.0 && slow[2] > settled + 4.0, "{slow:?}");
    let missing = "error: `--cut`: the sequence has no frame 7\n  hint: a cut is a frame that is rendered, as `--frames` \
                   or the files name it";
    folder.run("render meter.ron shot.#.exr -o out.#.exr --cut 2,7").fails(1, missing);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_exposure_and_repaired_pixels_are_reported() {
    let folder = Folder::new("readings");
    let bad = [[f32::NAN, 1.0, 1.0, 1.0], [f32::INFINITY, 1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, 1.0], [-1.0; 4]];
    save(&folder.file("bad.exr"), &gray(2.0, &bad));
    folder.with("meter.ron", METERED.as_bytes());
    let words = folder.run("render meter.ron bad.exr -o out.exr --json report.json").notes();
    assert!(words.contains("repaired pixels of `scene`: 1 NaN, 1 infinite, 1 negative"), "{words}");
    assert!(words.contains("exposure of `meter`: -3.") && words.contains("at EV100 3.97"), "{words}");
    let report = report(&folder, "report.json");
    let repaired = &report["frames"][0]["repaired"]["scene"];
    assert_eq!([&repaired["nan"], &repaired["infinite"], &repaired["negative"]], [1, 1, 1]);
    assert_eq!(report["summary"]["repaired"], 1);
    assert!((stops(&folder, "report.json")[0] - (0.18_f64.log2() - 1.0)).abs() < 0.05);
    // A gray card of 18 % has this luminance in so many lux.
    let lux = std::f64::consts::PI * 2.0 / 0.18;
    assert!((metered(&report, "lux")[0] / lux).log2().abs() < 0.05, "{report}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_image_without_the_mask_that_a_pipeline_needs_gets_a_warning() {
    let folder = Folder::new("mask");
    save(&folder.file("opaque.exr"), &gray(2.0, &[]));
    save(&folder.file("masked.exr"), &gray(2.0, &[[1.0, 1.0, 1.0, 0.0]]));
    let pipeline = "Pipeline(inputs: { \"scene\": Color(needs_alpha: true) }, nodes: { \
                    \"lit\": Extract(source: \"scene\", method: Emissive) }, outputs: { \"light\": \"lit\" })";
    folder.with("mask.ron", pipeline.as_bytes());
    let warning = "warning: the alpha of the image for input `scene` is 1 everywhere";
    assert!(folder.run("render mask.ron opaque.exr -o out.exr").notes().contains(warning));
    assert!(!folder.run("render mask.ron masked.exr -o out.exr").notes().contains("warning"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_factor_brings_brighter_light_into_range() {
    let folder = Folder::new("factor");
    let float = Encoding { bits: 32, ..Encoding::EXR };
    write_image(&folder.file("sun.exr"), &gray(4.0, &[[1e7, 2e6, -5.0, 0.5]]), &float).expect("it can be written");
    let pipeline = "Pipeline(inputs: { \"scene\": Color(scale: 0.001) }, nodes: {}, outputs: { \"light\": \"scene\" })";
    folder.with("scaled.ron", pipeline.as_bytes());
    folder.run("render scaled.ron sun.exr -o out.exr --depth 32").good();
    let out = afterimage_media::read(&afterimage_media::Source::file(folder.file("out.exr"))).expect("it was written");
    let close = |found: f32, wanted: f32| (found - wanted).abs() <= 1e-3 * wanted;
    let [r, g, b, a] = out.pixel(0, 0);
    assert!(close(r, 1e4) && close(g, 2e3) && close(-b, 5e-3) && a == 0.5, "{:?}", out.pixel(0, 0));
    assert!(close(out.pixel(3, 3)[0], 0.004), "{:?}", out.pixel(3, 3));
}
