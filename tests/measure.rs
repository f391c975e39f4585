//! `measure` and `tune` as a user runs them, on a tiny picture.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use afterimage_graph::check::Facts;
use afterimage_lab::measure::{MeasureOptions, SequenceOptions};
use afterimage_lab::tune::{Goal, MARGIN, TunePipeline, TuneTarget, claimed_p999, tune};
use afterimage_media::{Budget, Encoding, Picture, Pixels, write_image};
use afterimage_plan::Options;
use serde_json::Value;

/// A pipeline whose every switch matters: bloom, with a tier that is the file itself and one that is cheap.
const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "mips": Downsample(source: "scene", levels: 3, filter: Binomial),
        "bloom": Upsample(source: "mips", blend: Mix, filter: Tent),
        "lit": Composite(base: "scene", bloom: "bloom", blend: Mix, strength: 0.5),
        "exposed": Exposure(source: "lit", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: AcesNarkowicz),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
    tiers: { "same": {}, "cheap": { "mips.filter": Box, "bloom.filter": Bilinear } },
)"#;

/// A folder of its own for each test, removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("afterimage-measure-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        let folder = Self(path);
        std::fs::write(folder.file("glow.ron"), PIPELINE).unwrap();
        folder
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn arg(&self, name: &str) -> String {
        self.file(name).to_str().unwrap().to_owned()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.file(name)).unwrap()).unwrap()
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap()
    }

    /// A dim slope with a lamp that moves from frame to frame.
    fn picture(&self, name: &str, frame: u32) {
        let (width, height) = (41, 29);
        let pixel = |x: u32, y: u32| {
            let lamp = if x / 2 == 8 + frame && y / 3 == 4 { 40.0 } else { 0.0 };
            [0.02 * x as f32 + lamp, 0.01 * y as f32 + lamp, 0.1 + 0.5 * lamp, 1.0]
        };
        let pixels = (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect();
        write_image(&self.file(name), &Picture::new(width, height, Pixels::Float(pixels)), &Encoding::EXR).unwrap();
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

/// Runs the program; whether it went well.
fn run(arguments: &[&str]) -> bool {
    let adapter = std::env::var("AFTERIMAGE_ADAPTER").ok();
    let adapter: Vec<&str> = adapter.iter().flat_map(|name| ["--adapter", name.as_str()]).collect();
    let all = ["afterimage"].iter().chain(arguments).chain(&adapter).map(Into::into);
    let code = afterimage_cli::run(&[afterimage_nodes::ALL], all);
    format!("{code:?}") == format!("{:?}", std::process::ExitCode::SUCCESS)
}

/// The report of `measure` on the folder's pipeline and a picture.
fn report(folder: &Folder, picture: &str, more: &[&str]) -> Value {
    let (pipeline, picture, out) = (folder.arg("glow.ron"), folder.arg(picture), folder.arg("out.json"));
    let arguments = ["measure", &pipeline, &picture, "--repeats", "1", "--json", &out];
    assert!(run(&[&arguments, more].concat()));
    folder.json("out.json")
}

/// Every variant on one picture: what several tests look at, measured once.
fn report_of_a_still() -> &'static Value {
    static REPORT: OnceLock<Value> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = Folder::new("still");
        folder.picture("in.exr", 0);
        report(&folder, "in.exr", &[])
    })
}

fn row<'v>(report: &'v Value, variant: &str) -> &'v Value {
    let rows = report["rows"].as_array().unwrap();
    rows.iter()
        .find(|row| row["variant"] == variant)
        .unwrap_or_else(|| panic!("no row is called {variant}: {report:#}"))
}

fn number(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or_else(|| panic!("`{name}` is no number in {row:#}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_variant_is_compared_with_the_reference() {
    let report = report_of_a_still();
    assert!(["gpu", "host"].contains(&report["clock"].as_str().unwrap()));
    let reference = row(report, "reference");
    for name in ["max", "p999", "ciede2000_mean", "ciede2000_p999", "flip"] {
        assert_eq!(number(reference, name), 0.0, "{name}");
    }
    assert_eq!((number(reference, "ssim"), number(reference, "jod")), (1.0, 10.0));
    assert!(reference["psnr"].is_null(), "equal pictures have an infinite PSNR");
    let (written, same, cheap) = (row(report, "as written"), row(report, "tier same"), row(report, "tier cheap"));
    for name in ["max", "p999", "psnr", "ssim", "ciede2000_mean", "flip", "jod", "bytes", "bytes_moved", "gpu_ms"] {
        assert_eq!(number(written, name), number(same, name), "{name}");
    }
    assert!(same["same_as"] == "as written" && cheap["same_as"].is_null() && written["same_as"].is_null());
    // Half floats are off by a fraction of a code, the cheap filters by several.
    assert!((0.0..0.5).contains(&number(written, "p999")) && number(written, "max") > 0.0);
    for name in ["max", "p999", "ciede2000_mean", "flip"] {
        assert!(number(cheap, name) > 4.0 * number(written, name), "{name}");
    }
    assert!(number(cheap, "psnr") < number(written, "psnr") - 6.0 && number(cheap, "ssim") < number(written, "ssim"));
    assert!(number(cheap, "jod") < 9.0 && number(written, "jod") > 9.99, "half floats are not seen");
    assert!(number(reference, "bytes") > number(written, "bytes"));
    assert!(written["flicker_p999"].is_null(), "a single frame cannot flicker");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_switch_is_turned_on_its_own() {
    let report = report_of_a_still();
    let names: Vec<&str> =
        report["rows"].as_array().unwrap().iter().map(|row| row["variant"].as_str().unwrap()).collect();
    let switches = ["mips.filter=Tap13", "mips.filter=Tap9", "mips.filter=Tap4", "mips.filter=Box"];
    assert_eq!(names[..4], ["reference", "as written", "tier same", "tier cheap"]);
    assert_eq!(names[4..8], switches);
    assert!(names.contains(&"mips.format=Rg11b10Ufloat"), "{names:?}");
    // The tone map is fused into what follows, so its format is never stored.
    let without: Vec<&str> =
        report["without_effect"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert!(without.contains(&"mapped.format=Rg11b10Ufloat"), "{without:?}");
    let written = row(report, "as written");
    let packed = row(report, "mips.format=Rg11b10Ufloat");
    assert!(number(packed, "bytes") < number(written, "bytes") && number(packed, "p999") > number(written, "p999"));
    let best: Vec<bool> = report["rows"].as_array().unwrap().iter().map(|row| row["pareto"] == true).collect();
    assert!(!best[0] && best[1..].contains(&true));
}

/// Encoded pixels and light that ends at white can be codes; where alpha is coverage, it is kept.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_wire_is_measured_in_the_formats_that_may_hold_it() {
    let folder = Folder::new("wires");
    folder.picture("in.exr", 0);
    let encode = r#""display": Encode(source: "mapped", transfer: Srgb),"#;
    let moved = r#""display": Transform(source: "encoded", offset: (0.3, 0.4)),"#;
    let text = PIPELINE.replace(encode, &(encode.replace("display", "encoded") + moved));
    std::fs::write(folder.file("glow.ron"), &text).unwrap();
    let half = report(&folder, "in.exr", &[]);
    let written = row(&half, "as written");
    let mut last = number(written, "max");
    // A step of ten bits is a quarter of a code. A device may blend bytes with an error of a code.
    for (format, step) in [("Rgb10a2Unorm", 0.25), ("Rgba8Unorm", 1.5)] {
        let narrow = row(&half, &format!("encoded.format={format}"));
        let max = number(narrow, "max");
        assert!(max > last && max < number(written, "max") + step, "{format}: {max} after {last}");
        assert!(number(narrow, "bytes_moved") < number(written, "bytes_moved"), "{format}");
        last = max;
    }
    let names = |report: &Value| -> Vec<String> {
        let rows = report["rows"].as_array().unwrap().iter().map(|row| row["variant"].as_str().unwrap().to_owned());
        rows.filter(|name| name.contains(".format=")).collect()
    };
    let all = names(&half);
    assert!(!all.iter().any(|name| name.starts_with("mips") && name.ends_with("Unorm")), "light does not end: {all:?}");
    let covered =
        text.replace(r#"{ "display": "display" }"#, r#"{ "display": Output(source: "display", alpha: Coverage) }"#);
    std::fs::write(folder.file("glow.ron"), covered).unwrap();
    let kept = names(&report(&folder, "in.exr", &[]));
    assert!(kept.contains(&"encoded.format=Rgba8Unorm".to_owned()), "{kept:?}");
    assert!(!kept.iter().any(|name| name.ends_with("Rgb10a2Unorm") || name.ends_with("Rg11b10Ufloat")), "{kept:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sequences_show_what_flickers() {
    let folder = Folder::new("sequence");
    (0..3).for_each(|frame| folder.picture(&format!("in.{frame:04}.exr"), frame));
    let report = report(&folder, "in.####.exr", &[]);
    assert_eq!(report["images"][0]["frames"], 3);
    let (written, cheap) = (row(&report, "as written"), row(&report, "tier cheap"));
    assert_eq!(number(row(&report, "reference"), "flicker_max"), 0.0);
    assert!(number(cheap, "flicker_p999") > 4.0 * number(written, "flicker_p999"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grain_is_no_error() {
    let folder = Folder::new("grain");
    (0..2).for_each(|frame| folder.picture(&format!("in.{frame:04}.exr"), frame));
    let grain =
        r#""encoded": Encode(source: "mapped", transfer: Srgb), "display": FilmGrain(source: "encoded", amount: 0.5),"#;
    let text = PIPELINE.replace(r#""display": Encode(source: "mapped", transfer: Srgb),"#, grain);
    std::fs::write(folder.file("glow.ron"), text).unwrap();
    let report = report(&folder, "in.####.exr", &["--tiers"]);
    assert_eq!(report["rows"].as_array().unwrap().len(), 4, "the reference, the file, two tiers");
    let (written, cheap) = (row(&report, "as written"), row(&report, "tier cheap"));
    assert!(number(written, "p999") < 0.5 && number(written, "flicker_p999") < 0.5, "{written:#}");
    assert!(number(cheap, "p999") > 4.0 * number(written, "p999"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn charts_and_images_of_errors_are_written() {
    let folder = Folder::new("formats");
    folder.picture("a.exr", 0);
    folder.picture("b.exr", 3);
    let [svg, errors] = ["out.svg", "errors"].map(|name| folder.arg(name));
    let (pipeline, a, b) = (folder.arg("glow.ron"), folder.arg("a.exr"), folder.arg("b.exr"));
    assert!(run(&["measure", &pipeline, &a, &b, "--repeats", "1", "--plot", &svg, "--error-image", &errors]));
    let svg = folder.text("out.svg");
    assert!(svg.starts_with("<svg ") && svg.contains("tier cheap: "));
    assert!(folder.file("errors").join("a-tier-cheap.png").is_file());
}

/// Tiers in which one change makes nearly all of the error, and another nearly none.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_change_that_makes_an_error_is_named() {
    let folder = Folder::new("explain");
    (0..3).for_each(|frame| folder.picture(&format!("in.{frame:04}.exr"), frame));
    let tiers = r#"tiers: {
        "planted": { "mips.format": Rg11b10Ufloat, "bloom.filter": Bilinear },
        "dimmer": { "lit.strength": 0.4, "mips.filter": Tap13 },
    "#;
    std::fs::write(folder.file("glow.ron"), PIPELINE.replace("tiers: {", tiers)).unwrap();
    let share = |part: &Value| part["share"].as_f64().unwrap();
    for (tier, largest) in [("planted", "\"bloom.filter\": Bilinear"), ("dimmer", "\"lit.strength\": 0.4")] {
        let pictures = folder.arg(tier);
        let report = report(&folder, "in.####.exr", &["--explain", tier, "--error-image", &pictures]);
        let (found, row) = (&report["explained"], row(&report, &format!("tier {tier}")));
        assert_eq!((&found["variant"], &found["image"]), (&row["variant"], &row["images"][0]["image"]));
        // The frame is that with the largest p99.9, and another one may have a slightly larger single error.
        let (codes, max) = (number(found, "codes"), number(row, "max"));
        assert!((0.99 * max..max + 1e-3).contains(&codes), "{found:#} {row:#}");
        let changes = found["changes"].as_array().unwrap();
        assert_eq!((changes.len(), &changes[0]["change"]), (3, &Value::from(largest)), "{found:#}");
        assert!(share(&changes[0]) > 0.9, "{found:#}");
        let sum: f64 = changes.iter().chain([&found["remainder"]]).map(share).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{found:#}");
        let frame = found["frame"].as_u64().unwrap();
        for picture in ["worst-reference", "worst", "worst-error"] {
            let name = format!("in-{frame:04}-tier-{tier}-{picture}.png");
            assert!(folder.file(tier).join(&name).is_file(), "{name}");
        }
    }
    // Half floats alone make the error of a tier that is the file itself.
    let same = &report(&folder, "in.####.exr", &["--tiers", "--explain", "tier same"])["explained"];
    let changes = same["changes"].as_array().unwrap();
    assert_eq!((changes.len(), &changes[0]["change"]), (1, &Value::from("intermediates of 16 bits")), "{same:#}");
    assert!((share(&changes[0]) - 1.0).abs() < 1e-12 && share(&same["remainder"]).abs() < 1e-12, "{same:#}");
    assert!(!run(&["measure", &folder.arg("glow.ron"), &folder.arg("in.0000.exr"), "--explain", "tier lo"]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_no_picture_cannot_be_judged() {
    let folder = Folder::new("depth");
    let text = r#"Pipeline(inputs: {}, nodes: { "scene": DemoScene() }, outputs: { "depth": "scene.depth", "light": "scene" })"#;
    std::fs::write(folder.file("depth.ron"), text).unwrap();
    let pipeline = folder.arg("depth.ron");
    let measure = |output| {
        run(&[
            "measure",
            &pipeline,
            "--size",
            "16x12",
            "--repeats",
            "1",
            "--output",
            output,
            "--json",
            &folder.arg("out.json"),
        ])
    };
    assert!(!measure("depth") && !measure("nothing"));
    assert!(!folder.file("out.json").exists());
    // Linear light is judged as an HDR screen shows it.
    assert!(measure("light"));
    let report = folder.json("out.json");
    assert_eq!(report["output"], "light");
    let written = row(&report, "as written").clone();
    assert!(
        number(&written, "max") > 0.0 && number(&written, "deitp_p999") < 1.0 && written["ciede2000_mean"].is_null()
    );
}

/// The arguments of a search on the picture, with more of them.
fn tuned(folder: &Folder, more: &[&str]) -> bool {
    let (pipeline, picture) = (folder.arg("glow.ron"), folder.arg("in.exr"));
    let mut arguments = vec!["tune", &pipeline, &picture, "--repeats", "1"];
    arguments.extend(more);
    run(&arguments)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tuning_writes_a_tier_that_keeps_its_promise() {
    let folder = Folder::new("tune");
    folder.picture("in.exr", 0);
    let (out, state) = (folder.arg("tuned.ron"), folder.arg("state.json"));
    assert!(tuned(&folder, &["--error", "1000", "-o", &out, "--state", &state]));
    let text = folder.text("tuned.ron");
    assert!(text.contains("extends: \"glow.ron\"") && text.contains("\"tuned\": Claim(ms: "), "{text}");
    let render =
        |tier: &str| run(&["render", &out, &folder.arg("in.exr"), "-o", &folder.arg("out.png"), "--tier", tier]);
    assert!(render("tuned") && render("cheap") && !render("unknown"));
    assert!(!tuned(&folder, &["--error", "0.0", "--state", &state]), "half floats cannot be without error");
}

/// The claim of a tier is a tenth above the measured error.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tuned_tier_claims_what_is_measured() {
    let folder = Folder::new("claim");
    // The lamp, which makes errors, is in the second frame of a sequence only.
    for (name, frame) in [("in.exr", 1000), ("shot.0.exr", 1000), ("shot.1.exr", 0)] {
        folder.picture(name, frame);
    }
    let (out, json, state) = (folder.arg("tuned.ron"), folder.arg("out.json"), folder.arg("state.json"));
    let shot = folder.arg("shot.#.exr");
    assert!(tuned(&folder, &[&shot, "--error", "1000", "-o", &out, "--state", &state]));
    assert!(run(&["measure", &out, &folder.arg("in.exr"), &shot, "--tiers", "--repeats", "1", "--json", &json]));
    let claim = folder.text("tuned.ron");
    let claim = claim.split("p999: ").nth(1).and_then(|rest| rest.split(',').next());
    let claim: f64 = claim.and_then(|claim| claim.parse().ok()).expect("the file states its error");
    let measured = number(row(&folder.json("out.json"), "tier tuned"), "p999");
    assert!((claim - claimed_p999(measured)).abs() <= 0.0011, "{claim} claimed, {measured} measured");
}

/// The search does not see the second picture, whose lamp is what makes errors.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_claim_holds_on_a_picture_that_the_search_has_not_seen() {
    let folder = Folder::new("unseen");
    folder.picture("in.exr", 1000);
    folder.picture("lamp.exr", 0);
    let (out, json, lamp) = (folder.arg("tuned.ron"), folder.arg("out.json"), folder.arg("lamp.exr"));
    assert!(tuned(&folder, &[&lamp, "--error", "3", "-o", &out]));
    let text = folder.text("tuned.ron");
    assert!(text.contains("a tenth above the worst of 2 images, 1 of them new to the search: "), "{text}");
    assert!(run(&["measure", &out, &folder.arg("in.exr"), &lamp, "--tiers", "--repeats", "1", "--json", &json]));
    let (claim, row) = (claims(&text)[0].1[1], row(&folder.json("out.json"), "tier tuned").clone());
    // Which choice is fastest, and so which picture is worst, depends on the clock.
    let [seen, new] = [0, 1].map(|at| number(&row["images"][at], "p999"));
    assert!((claim - claimed_p999(seen.max(new))).abs() <= 0.0011 && claim <= 3.0, "{claim}: {row:#}");
}

/// Without `--no-charts`, tiers are tuned on the built-in pictures, too.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tiers_are_claimed_on_charts() {
    let folder = Folder::new("claimed-charts");
    folder.picture("in.exr", 0);
    let out = folder.arg("tuned.ron");
    let mut worst = Vec::new();
    for more in [&[][..], &["--no-charts"]] {
        assert!(tuned(&folder, &[&["--tiers=best:0", "-o", &out], more].concat()));
        let text = folder.text("tuned.ron");
        worst.push(claims(&text)[0].1[1]);
        assert_eq!(
            text.contains("the worst of 12 images and 4 sequences, 9 of them new to the search: "),
            more.is_empty(),
            "{text}"
        );
        assert_eq!(text.contains("errors a tenth above those of in\""), !more.is_empty(), "{text}");
    }
    assert!(worst[0] > worst[1], "{worst:?}");
    assert!(
        !tuned(&folder, &["--tiers", "--charts", "--no-charts"]) && !tuned(&folder, &["--error", "1", "--no-charts"])
    );
}

/// The claims of a file, for `desk`: tier, `ms`, `p999`, `flip`, `jod`.
fn claims(text: &str) -> Vec<(String, [f64; 4])> {
    let document = afterimage_graph::document::parse("tuned.ron", text).unwrap();
    let figures = |claim: &afterimage_graph::document::Claim| {
        assert_eq!(claim.display.as_deref(), Some("desk"), "{claim}");
        [claim.ms, claim.p999, claim.flip, claim.jod].map(Option::unwrap)
    };
    document.claims.iter().map(|(tier, claim)| (tier.value.clone(), figures(claim))).collect()
}

/// One command writes all tiers that are worth it, with claims that `measure` confirms.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn all_tiers_are_tuned_at_once() {
    let folder = Folder::new("ladder");
    folder.picture("in.exr", 0);
    folder.picture("other.exr", 3);
    let (out, json, state) = (folder.arg("tuned.ron"), folder.arg("out.json"), folder.arg("state.json"));
    let other = folder.arg("other.exr");
    assert!(tuned(&folder, &[&other, "--tiers", "--no-charts", "-o", &out, "--state", &state]));
    let text = folder.text("tuned.ron");
    let claims = claims(&text);
    let limits = [("ultra", 1.0), ("high", 1.0), ("medium", 4.0), ("low", 12.0)];
    assert_eq!(claims[0].0, "ultra", "{text}");
    assert!(run(&["measure", &out, &folder.arg("in.exr"), &other, "--tiers", "--repeats", "1", "--json", &json]));
    let mut last = f64::INFINITY;
    for (tier, [ms, p999, flip, jod]) in &claims {
        let limit = limits.iter().find(|(name, _)| name == tier).expect("the names are those of the ladder").1;
        let row = row(&folder.json("out.json"), &format!("tier {tier}")).clone();
        let codes = number(&row, "p999");
        assert!((p999 - (MARGIN * codes).max(codes + 0.05)).abs() <= 0.0011, "{tier}: {p999}, {row:#}");
        assert!(*p999 <= limit, "{tier}: {p999}, {row:#}");
        let (seen, lost) = (number(&row, "flip"), 10.0 - number(&row, "jod"));
        assert!((flip - (MARGIN * seen).max(seen + 0.003)).abs() <= 0.0011, "{tier}: {flip}, {row:#}");
        assert!((10.0 - jod - (MARGIN * lost).max(lost + 0.02)).abs() <= 0.0011, "{tier}: {jod}, {row:#}");
        assert!(*ms <= 0.75 * last + 0.001, "{text}");
        last = *ms;
    }
    // With every figure known, only the times of the tiers are measured again.
    let before = folder.json("state.json");
    assert!(tuned(&folder, &[&other, "--tiers", "--no-charts", "-o", &out, "--state", &state]));
    assert_eq!(folder.json("state.json")["measured"], before["measured"]);
    // No choice is within a hundredth of a code; a tier that cannot be does not prevent another.
    let rough = "--tiers=none:0.01,rough:1000";
    assert!(tuned(&folder, &[&other, rough, "--no-charts", "-o", &out, "--state", &state]));
    let text = folder.text("tuned.ron");
    assert!(text.contains("\"rough\": Claim(") && !text.contains("none"), "{text}");
    for wrong in ["--tiers=a", "--tiers=a:-1", "--tiers=a:1,a:2", "--tiers=a:2,b:1", "--tiers=a:1,b:1"] {
        assert!(!tuned(&folder, &[&other, wrong, "--no-charts", "--state", &state]), "{wrong}");
    }
    assert!(!tuned(&folder, &["--tiers", "--error", "1"]) && !tuned(&folder, &["--tiers", "--name", "a"]));
}

/// The steps that a search reports.
#[derive(Default)]
struct Told(std::sync::Mutex<Vec<(u64, u64)>>);

impl Told {
    /// Steps that are done and the most that there are, as told last.
    fn change(&self, change: impl FnOnce(&mut (u64, u64))) {
        let mut all = self.0.lock().unwrap();
        let mut last = all.last().copied().unwrap_or((0, u64::MAX));
        change(&mut last);
        all.push(last);
    }
}

impl afterimage_lab::Progress for Told {
    fn expect(&self, steps: u64) {
        self.change(|(_, most)| *most = steps);
    }

    fn end(&self) {
        self.change(|(done, _)| *done += 1);
    }
}

/// The bar of a search never goes back, is never full before the end, and is full in the end.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_steps_of_a_search_are_told_as_they_are() {
    let folder = Folder::new("steps");
    folder.picture("in.exr", 0);
    folder.picture("other.exr", 3);
    let graph = crate::support::gpu::graph(PIPELINE);
    let pipeline = TunePipeline { written: graph.clone(), ideal: graph, facts: Vec::new() };
    let clips = SequenceOptions {
        images: vec![folder.arg("in.exr"), folder.arg("other.exr")],
        inputs: Vec::new(),
        scene: false,
        charts: false,
        sizes: Vec::new(),
        walk: 1,
        frames: None,
        fps: 24.0,
        budget: Budget(1 << 28),
    };
    let options = MeasureOptions {
        sequences: clips,
        facts: Facts::default(),
        options: Options::default(),
        samples: Some(1),
        output: None,
        display: None,
        tiers_only: false,
        error_images: None,
    };
    let goal = |name: &str, target| Goal { name: name.to_owned(), target };
    let ladder = [
        goal("best", TuneTarget::MostAccurate),
        goal("good", TuneTarget::Error(3.0)),
        goal("fast", TuneTarget::Error(1000.0)),
    ];
    let state = folder.file("state.json");
    let gpu = crate::support::gpu::gpu();
    for (goals, state) in
        [(&ladder[..], Some(&*state)), (&ladder[..], Some(&*state)), (&ladder[1..2], None), (&ladder[..1], None)]
    {
        let told = Told::default();
        tune(&gpu, &crate::support::gpu::registry(), &pipeline, &options, goals, state, &told).unwrap();
        let told = told.0.into_inner().unwrap();
        assert!(told.windows(2).all(|pair| pair[0].1 >= pair[1].1), "the bar goes back: {told:?}");
        let (last, before) = told.split_last().expect("something is measured");
        assert!(last.0 == last.1 && before.iter().all(|(done, most)| done < most || *done == last.0), "{told:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tuned_tier_holds_what_the_command_line_and_another_tier_change() {
    let folder = Folder::new("stack");
    folder.picture("in.exr", 0);
    let more = r#"tiers: { "small": { "mips.levels": 2, "mips.filter": Box }, "film": "film.ron","#;
    std::fs::write(folder.file("glow.ron"), PIPELINE.replace("tiers: {", more)).unwrap();
    let film = PIPELINE.replace(r#"Exposure(source: "lit""#, r#"Exposure(source: "scene""#);
    std::fs::write(folder.file("film.ron"), film).unwrap();
    let out = folder.arg("tuned.ron");
    // The error of fewer levels counts, and no filter makes up for it; what `--set` asks for is no error.
    assert!(!tuned(&folder, &["--tier", "small", "--error", "0.5"]));
    assert!(tuned(&folder, &["--tier", "small", "--set", "exposed.stops=-1.5", "--budget", "10000ms", "-o", &out]));
    let text = folder.text("tuned.ron");
    assert!(text.contains("\"mips.levels\": 2") && text.contains("\"exposed.stops\": -1.5"), "{text}");
    // With two levels, `Tap13` may be nearer to the file's three than its own `Binomial`.
    assert!(!text.contains("\"mips.filter\": Box"), "the filter of the tier is searched anew: {text}");
    assert!(tuned(&folder, &["--set", "exposed.stops=-1.5", "--error", "0.5", "-o", &out]));
    assert!(!tuned(&folder, &["--tier", "film", "--error", "1000"]), "another pipeline");
}

/// Tables in the place of nodes are switches of a file that has them.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tables_are_measured_and_chosen() {
    let folder = Folder::new("tables");
    folder.picture("in.exr", 0);
    let text = PIPELINE.replace("curve: AcesNarkowicz)", "curve: AcesNarkowicz, bake: Auto)");
    assert_ne!(text, PIPELINE);
    std::fs::write(folder.file("glow.ron"), text).unwrap();
    let report = report(&folder, "in.exr", &[]);
    let errors = ["mapped.bake=Off", "as written", "mapped.bake=33"].map(|name| number(row(&report, name), "p999"));
    assert!(errors.is_sorted() && errors[0] < errors[2], "{errors:?}");
    assert!(number(row(&report, "mapped.bake=48"), "p999") > errors[0]);
    let out = folder.arg("tuned.ron");
    assert!(tuned(&folder, &["--budget", "10000ms", "-o", &out]));
    assert!(folder.text("tuned.ron").contains("\"mapped.bake\": Off"), "{}", folder.text("tuned.ron"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_search_goes_on_where_it_was_interrupted() {
    let folder = Folder::new("resume");
    folder.picture("in.exr", 0);
    let (out, state) = (folder.arg("tuned.ron"), folder.arg("state.json"));
    let search = || {
        assert!(tuned(&folder, &["--error", "2", "-o", &out, "--state", &state]));
        (folder.text("tuned.ron"), folder.json("state.json"))
    };
    let (_, mut content) = search();
    let measured = content["measured"].as_object_mut().unwrap();
    assert!(measured.len() > 4);
    // The exact pipeline is forgotten and measured anew; the figures of all others stay as they are.
    let exact = measured.remove("most accurate").unwrap();
    let kept = measured.clone();
    std::fs::write(folder.file("state.json"), content.to_string()).unwrap();
    let (text, after) = search();
    assert_eq!(after["measured"]["most accurate"]["p999"], exact["p999"]);
    kept.iter().for_each(|(choice, figures)| assert_eq!(after["measured"][choice], *figures, "{choice}"));
    // With every figure known nothing is left to chance.
    assert_eq!(search(), (text, after));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn figures_of_another_identity_are_refused() {
    let folder = Folder::new("state");
    folder.picture("in.exr", 0);
    let state = folder.arg("state.json");
    assert!(tuned(&folder, &["--error", "1000", "-o", &folder.arg("tuned.ron"), "--state", &state]));
    std::fs::write(folder.file("glow.ron"), PIPELINE.replace("levels: 3", "levels: 2")).unwrap();
    assert!(!tuned(&folder, &["--error", "1000", "--state", &state]));
    std::fs::write(folder.file("state.json"), "{}").unwrap();
    assert!(!tuned(&folder, &["--error", "1000", "--state", &state]));
    assert!(
        !tuned(&folder, &["--error", "1000", "-o", &folder.arg("glow.ron")]),
        "the pipeline itself is not overwritten"
    );
    assert!(!Path::new(&folder.arg("out.ron")).exists());
}

/// The claim of a tier is that of its worst image, and what the others would have claimed stands beside it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_folder_and_built_in_charts_are_measured() {
    let folder = Folder::new("charts");
    // The charts have half a million pixels: one pass is enough.
    let text = r#"Pipeline(inputs: { "scene": Color },
        nodes: {
            "exposed": Exposure(source: "scene"),
            "mapped": ToneMap(source: "exposed"),
            "display": Encode(source: "mapped"),
        },
        outputs: { "display": "display" }, tiers: { "cheap": { "mapped.curve": ReinhardExtended } })"#;
    std::fs::write(folder.file("glow.ron"), text).unwrap();
    std::fs::create_dir(folder.file("pictures")).unwrap();
    for (name, frame) in [("b.exr", 0), ("a.exr", 3)] {
        folder.picture(&format!("pictures/{name}"), frame);
    }
    std::fs::write(folder.file("pictures/notes.txt"), "no image").unwrap();
    let report = report(&folder, "pictures", &["--charts", "--tiers"]);
    let images: Vec<&str> =
        report["images"].as_array().unwrap().iter().map(|image| image["image"].as_str().unwrap()).collect();
    assert_eq!(images[..2], ["a", "b"]);
    assert!(
        ["lines", "dots", "one sun", "white", "black", "night", "pan", "cuts"].iter().all(|name| images.contains(name))
    );
    let cheap = row(&report, "tier cheap");
    let mut errors: Vec<f64> = cheap["images"].as_array().unwrap().iter().map(|image| number(image, "p999")).collect();
    errors.sort_by(f64::total_cmp);
    let [.., second, first] = errors[..] else { panic!("{errors:?}") };
    assert_eq!((number(cheap, "p999"), number(cheap, "p999_without_worst")), (first, second));
    assert!(!run(&["measure", &folder.arg("glow.ron"), &folder.arg("."), "--tiers"]), "the folder has no image");
}
