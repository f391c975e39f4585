//! Every built-in pipeline rendered under the validation layer, in every way and at every tier.

use std::iter::zip;

use afterimage_graph::check::Graph;
use afterimage_graph::node::Bake;
use afterimage_graph::value::Value;
use afterimage_lab::metrics::{PIXELS_PER_DEGREE, Range, Shown, flip, srgb_decode, srgb_encode};
use afterimage_lab::tune::{claimed_flip, claimed_jod, claimed_p999};
use afterimage_plan::{Alias, When};

use crate::support::gpu::{Picture, Run, built_in, document, graph, pipelines, tiers};
use crate::support::layer;
use crate::support::sweep;

/// The files in the folder: a new one is tested without being named here.
pub fn files() -> Vec<String> {
    let entries = std::fs::read_dir(pipelines()).expect("the repository has pipelines");
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".ron"))
        .collect();
    names.sort();
    assert!(names.len() >= 6, "only {names:?}");
    names
}

fn scene(width: u32, height: u32) -> Picture {
    let graph = graph(r#"Pipeline(inputs: {}, nodes: { "scene": DemoScene() }, outputs: { "scene": "scene" })"#);
    let mut run = Run::new(&graph);
    run.size = afterimage_graph::image::Size::new(width, height);
    run.frame(&[]).remove(0)
}

fn required<'p>(graph: &Graph, picture: &'p Picture) -> Vec<(String, &'p Picture)> {
    graph.inputs.iter().filter(|input| !input.optional).map(|input| (input.name.clone(), picture)).collect()
}

fn frame(run: &Run<'_>, picture: &Picture) -> Vec<Picture> {
    let inputs = required(run.graph, picture);
    let inputs: Vec<(&str, &Picture)> = inputs.iter().map(|(name, picture)| (name.as_str(), *picture)).collect();
    run.frames(&inputs, &[(0.0, true), (1.0 / 24.0, false)]).pop().expect("two frames")
}

fn worst(a: &[Picture], b: &[Picture]) -> f32 {
    let pixels =
        |pictures: &[Picture]| pictures.iter().flat_map(|p| p.pixels.as_flattened().to_vec()).collect::<Vec<f32>>();
    pixels(a).iter().zip(pixels(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Half floats and the eight-bit weights of filters allow this much; display values lie in 0..1.
const ONE_CODE: f32 = 1.0 / 255.0;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_renders_a_picture_without_a_word_from_the_layer() {
    let _alone = layer::alone();
    assert!(layer::is_installed(), "the validation layer is missing: apt-get install vulkan-validationlayers");
    let scene = scene(192, 108);
    layer::messages();
    for name in files() {
        let graph = built_in(&name, None);
        let pictures = frame(&Run::new(&graph), &scene);
        let values = pictures[0].pixels.as_flattened();
        assert!(values.iter().all(|x| x.is_finite()), "{name}: not finite");
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        assert!((0.1..0.9).contains(&mean), "{name}: a mean of {mean} is no picture");
        assert_eq!(layer::messages(), Vec::<String>::new(), "{name}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_way_to_run_a_pipeline_makes_the_same_picture() {
    let _alone = layer::alone();
    let scene = scene(160, 90);
    layer::messages();
    let is_chosen = |name: &str| sweep::is_whole() || ["lynx.ron", "tsushima.ron"].contains(&name);
    for name in files().into_iter().filter(|name| is_chosen(name)) {
        let graph = built_in(&name, None);
        let reference = frame(&Run::new(&graph), &scene);
        let with = |change: fn(&mut Run<'_>)| {
            let mut run = Run::new(&graph);
            change(&mut run);
            frame(&run, &scene)
        };
        let same = |way: &str, pictures: &[Picture], tolerance: f32| {
            let worst = worst(&reference, pictures);
            let most = if decides(&graph) && tolerance > 0.0 { DECIDED } else { tolerance };
            assert!(worst <= most, "{name}, {way}: differs by {worst}");
            let off = codes_off(&reference, pictures);
            assert!(off <= 255.0 * tolerance + 0.01, "{name}, {way}: one value in a thousand differs by {off} codes");
            assert_eq!(layer::messages(), Vec::<String>::new(), "{name}, {way}");
        };
        same("without aliasing", &with(|run| run.options.alias = Alias::None), 0.0);
        same("with the pool", &with(|run| run.options.alias = Alias::Pool), 0.0);
        same("serial", &with(|run| run.options.serial = true), 0.0);
        same("fewest batches", &with(|run| run.options.batches_first = true), 0.0);
        same("checked", &with(|run| run.options.bounds_checks = true), 0.0);
        same("in fragments", &with(|run| run.prefer_fragment = true), ONE_CODE);
        same("not fused", &with(|run| run.options.fuse = false), 2.0 * ONE_CODE);
        // Taps by hand have all bits of the weights, those of the device eight; the dither then decides for one code or the next.
        same("by rows", &with(|run| run.options.row_downsample = When::Always), 1.5 * ONE_CODE);
        same("again", &with(|_| {}), 0.0);
    }
}

/// How far a pixel may be off where rounding decides whether, and how far, an edge is smoothed. On an NVIDIA H200 one
/// is off by 17 codes, on SwiftShader by 26.
const DECIDED: f32 = 32.0 * ONE_CODE;

/// True if a pipeline has a node that treats nearly equal pixels in different ways.
fn decides(graph: &Graph) -> bool {
    graph.nodes.iter().any(|node| node.kind().name() == "Fxaa")
}

/// Codes that one value in a thousand exceeds.
fn codes_off(a: &[Picture], b: &[Picture]) -> f32 {
    let values =
        |pictures: &[Picture]| pictures.iter().flat_map(|p| p.pixels.as_flattened().to_vec()).collect::<Vec<f32>>();
    let mut off: Vec<f32> = values(a).iter().zip(values(b)).map(|(a, b)| 255.0 * (a - b).abs()).collect();
    off.sort_by(f32::total_cmp);
    off[off.len() - 1 - off.len() / 1000]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_tiers_of_each_keep_its_look() {
    let scene = scene(320, 180);
    for name in sweep::some(files(), 3) {
        let at = |tier: &str| frame(&Run::new(&built_in(&name, Some(tier))), &scene);
        let known = tiers(&name);
        assert!(known[0] == "ultra" && known.len() > 1, "{name}: {known:?}");
        let ultra = at("ultra");
        for tier in &known[1..] {
            // What they state, and two codes for the dither on either side.
            let mut claims = document(&name).claims.into_iter();
            let claim = claims.find(|(known, _)| known.value == *tier).and_then(|(_, claim)| claim.p999);
            let most = claim.expect("a tier claims an error") + 2.0;
            let off = f64::from(codes_off(&ultra, &at(tier)));
            assert!(off <= most, "{name}, {tier}: {off} codes");
        }
    }
}

/// Errors are differences from a pipeline whose switches are all at their most accurate values: a choice that looks better
/// than all of them is an error of every tier, unless the kind names it first.
#[test]
fn the_best_tier_has_the_values_that_errors_are_measured_against() {
    for name in files() {
        for node in built_in(&name, Some("ultra")).nodes.iter().filter(|node| !node.off) {
            for (param, value) in node.kind().params().iter().zip(node.instance.values()) {
                let is_cheaper = param.quality.as_ref().is_some_and(|quality| quality.cheaper.contains(value));
                let is_choice = matches!(value, Value::Choice(_));
                assert!(!(is_choice && is_cheaper), "{name}: {}.{} is {value}", node.name, param.name);
            }
            let frames_and_table = (node.every, node.bake.unwrap_or(Bake::Off));
            assert_eq!(frames_and_table, (1, Bake::Off), "{name}: {}", node.name);
        }
    }
}

/// A tenth, less what two times differ by when they are measured again.
const MAX_SHARE: f64 = 0.92;

/// A fast card waits for passes as much as for memory; on others, bytes are the time. Tiers are judged once they have a
/// time: one that was measured on a processor alone claims none.
#[test]
fn a_tier_takes_a_tenth_less_time_or_memory_traffic_than_the_next_better_one() {
    // The times are of a frame without depth, with which the tiers of `cinematic.ron` differ by more. `upscale.ron` has
    // the tiers of `mobile.ron`, where they pay: its enlargement takes most of the time.
    let table = include_str!("../graph/docs/measurements/tiers.csv");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().expect("a number");
    for name in files().into_iter().filter(|name| !["cinematic.ron", "upscale.ron"].contains(&&**name)) {
        let is_tier = |row: &&Vec<&str>| row[0] == name.trim_end_matches(".ron") && row[1] != "as written";
        let mut tiers: Vec<_> = rows.iter().filter(is_tier).collect();
        let error = |row: &[&str]| number(row, 4).max(number(row, 7));
        tiers.sort_by(|a, b| error(a).total_cmp(&error(b)));
        for [better, tier] in tiers.array_windows().filter(|pair| pair.iter().all(|row| !row[2].is_empty())) {
            let share = |column: usize| number(tier, column) / number(better, column);
            let (time, bytes) = (share(2), share(14));
            assert!(
                time.min(bytes) <= MAX_SHARE,
                "{name}: `{}` takes {time:.3} of the time of `{}`",
                tier[1],
                better[1]
            );
        }
    }
}

/// A sky with lamps that no size makes smaller than two pixels.
fn lamps(height: u32) -> Picture {
    const LAMPS: [[f32; 4]; 5] = [
        [0.3, 0.3, 0.02, 30.0],
        [0.9, 0.6, 0.05, 8.0],
        [1.2, 0.2, 0.03, 60.0],
        [1.5, 0.7, 0.1, 3.0],
        [0.5, 0.8, 0.04, 12.0],
    ];
    Picture::new(height * 16 / 9, height, |x, y| {
        let [x, y] = [x, y].map(|at| (at as f32 + 0.5) / height as f32);
        let mut light = 0.05 + 0.3 * (1.0 - y) * (1.0 - y);
        let mut is_lamp = 0.0_f32;
        for [at_x, at_y, radius, brightness] in LAMPS {
            let inside = 1.0 / (1.0 + (4.0 * ((x - at_x).hypot(y - at_y) / radius - 1.0)).exp());
            light += brightness * inside;
            is_lamp = is_lamp.max(inside);
        }
        [light, 0.8 * light, 0.6 * light, is_lamp]
    })
}

/// The picture in a third of its size, by the mean of its light.
fn third(picture: &Picture) -> Picture {
    let mean = |x: u32, y: u32, channel: usize| {
        let places = (0..9).map(|at| (3 * y + at / 3) * picture.width + 3 * x + at % 3);
        let light = places.map(|at| srgb_decode(f64::from(picture.pixels[at as usize][channel]))).sum::<f64>() / 9.0;
        srgb_encode(light) as f32
    };
    let size = [picture.width / 3, picture.height / 3];
    Picture::new(size[0], size[1], |x, y| [mean(x, y, 0), mean(x, y, 1), mean(x, y, 2), 1.0])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_look_is_the_same_in_a_small_picture() {
    for name in sweep::some(["caracal.ron", "glare.ron", "lynx.ron", "tsushima.ron"], 2) {
        let graph = built_in(name, None);
        let [large, small] = [540, 180].map(|height| frame(&Run::new(&graph), &lamps(height)).remove(0));
        let [large, small] = [&third(&large), &small].map(|picture| Shown {
            width: picture.width as usize,
            height: picture.height as usize,
            range: Range::Sdr,
            pixels: picture.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        });
        let errors = flip(&large, &small, PIXELS_PER_DEGREE);
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        assert!(mean < 0.025, "{name}: FLIP {mean}");
    }
}

#[test]
fn the_table_of_tiers_has_those_of_all_pipelines_with_what_they_claim() {
    let table = include_str!("../graph/docs/measurements/tiers.csv");
    let mut measured = Vec::new();
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [pipeline, tier, ms, _, p999, flip, _, p999_moving, flip_moving, ..] = *fields else { panic!("{line}") };
        let number = |figure: &str| figure.parse::<f64>().expect("a number");
        let p999 = format!("{:.2}", claimed_p999(number(p999).max(number(p999_moving))));
        let flip = format!("{:.3}", claimed_flip(number(flip).max(number(flip_moving))));
        let [ms, p999, flip] = [ms, &p999, &flip].map(|figure| figure.parse::<f64>().ok());
        // A table from before the metric has no JOD, and neither have the claims that were made of it.
        let jod = fields.get(16..).map(|seen| {
            let [jod, jod_moving, _, display, ..] = *seen else { panic!("{line}") };
            let worst = number(jod).min(number(jod_moving));
            (format!("{:.3}", claimed_jod(worst)), display.to_owned())
        });
        if tier != "as written" {
            measured.push((pipeline.to_owned(), tier.to_owned(), ms, p999, flip, jod));
        }
    }
    let mut known = Vec::new();
    for name in files() {
        for tier in tiers(&name) {
            let claims = document(&name).claims;
            let claim = claims.into_iter().find(|(of, _)| of.value == tier).map(|(_, claim)| claim).unwrap_or_default();
            let jod = claim.jod.map(|jod| format!("{jod:.3}")).zip(claim.display);
            known.push((name.trim_end_matches(".ron").to_owned(), tier, claim.ms, claim.p999, claim.flip, jod));
        }
    }
    measured.sort_by(|a, b| (&a.0, &a.1).cmp(&(&b.0, &b.1)));
    known.sort_by(|a, b| (&a.0, &a.1).cmp(&(&b.0, &b.1)));
    assert_eq!(measured, known, "run tests/tiers.sh, and then tests/tiers.py claims");
}

/// The shares of bytes and of operations by which a plan may differ from the one that was timed. Passes wait for memory:
/// a fifth more operations once took a tenth less time.
const STALE: [f64; 2] = [0.02, 0.1];

/// A time or an error cannot be tested, but what was measured can: a row is stale when its plan costs more or less than it
/// did then, or when a value of the pipeline, or of one that it extends, is another.
#[test]
fn what_tiers_claim_is_of_their_plans_and_values() {
    let prices = include_str!("../graph/plan/tests/golden/prices.txt");
    let price = |name: &str| -> Option<([f64; 2], &str)> {
        let figures = prices.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
        let [megabytes, _, _, operations, _, values] = *figures.split_whitespace().collect::<Vec<_>>() else {
            return None;
        };
        Some(([megabytes.parse().ok()?, operations.parse().ok()?], values))
    };
    for line in include_str!("../graph/docs/measurements/tiers.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [pipeline, tier, ..] = *fields else { panic!("{line}") };
        let [megabytes, operations, measured] = [fields[14], fields[15], fields[fields.len() - 1]];
        let name = format!("{pipeline} {tier}");
        let (now, values) = price(&name).unwrap_or_else(|| panic!("prices.txt has no `{name}`"));
        let timed = [megabytes, operations].map(|figure| figure.parse::<f64>().expect("a number"));
        let is_as_timed =
            zip(zip(now, timed), STALE).all(|((now, timed), share)| (now - timed).abs() <= share * timed + 0.051);
        assert!(
            is_as_timed,
            "`{name}` had {timed:?} MB and operations when it was timed, and has {now:?}: time it again"
        );
        assert_eq!(
            values, measured,
            "a value of `{name}`, its own or one of what it extends, is not that of its errors: measure it again, or set \
             in it what it was measured with"
        );
    }
}

/// A second Vulkan, with small limits: four bind groups, 256 invocations.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(not(no_swiftshader))]
fn small_limits_make_the_same_pictures() {
    let folder = std::env::temp_dir().join(format!("afterimage-swiftshader-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let picture = scene(96, 54);
    let pixels = picture.pixels.as_flattened().to_vec();
    let source = folder.join("scene.exr");
    let exr = afterimage_media::Picture::new(96, 54, afterimage_media::Pixels::Float(pixels));
    let options = afterimage_media::Encoding { bits: 32, ..afterimage_media::Encoding::EXR };
    afterimage_media::write_image(&source, &exr, &options).expect("a temporary file");
    for name in sweep::some(files(), 3) {
        let render = |driver: Option<&str>, out: &str| {
            let mut command = crate::support::command::program(&folder);
            command.arg("render").arg(pipelines().join(&name)).arg(&source).arg("-o").arg(folder.join(out));
            if let Some(driver) = driver {
                command.env("VK_ICD_FILENAMES", driver).env("VK_DRIVER_FILES", driver);
            }
            let output = command.output().expect("the program starts");
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
            let picture = afterimage_media::read(&afterimage_media::Source::file(folder.join(out)));
            picture.expect("a picture was written").pixels.to_f32()
        };
        let (here, there) = (render(None, "here.png"), render(Some(env!("SWIFTSHADER")), "there.png"));
        // Files are read back as light; compared as the codes they hold.
        let code = |x: f32| (255.0 * x.max(0.0).powf(1.0 / 2.2)).round();
        let mut off: Vec<f32> = here.iter().zip(&there).map(|(a, b)| (code(*a) - code(*b)).abs()).collect();
        off.sort_by(f32::total_cmp);
        let (worst, most) = (off[off.len() - 1], off[off.len() - 1 - off.len() / 1000]);
        // With one value in 600 off by more than a code, where an edge is smoothed decides one in a thousand.
        let limits = if decides(&built_in(&name, None)) { [4.0, 255.0 * DECIDED] } else { [2.0, 2.0] };
        let is_alike = most <= limits[0] && worst <= limits[1];
        assert!(is_alike, "{name}: differs by {worst} codes, one in a thousand by {most}");
    }
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
}

#[test]
#[cfg(no_swiftshader)]
#[ignore = "SwiftShader is not installed: apt-get install chromium brings it"]
fn small_limits_make_the_same_pictures() {}
