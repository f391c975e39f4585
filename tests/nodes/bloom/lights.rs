//! Built-in pipelines with lights: moving lights, suns, and a single infinite pixel.

use afterimage_graph::check::Graph;
use afterimage_plan::When;

use super::fireflies::{light, variation};
use crate::support::gpu::{Picture, Run, built_in, changed, graph, pipelines};
use crate::support::sequence::Sequence;
use crate::support::sweep;

/// The text of a built-in pipeline.
fn text(name: &str) -> String {
    std::fs::read_to_string(pipelines().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The sum of the bloom of a light of 2x2 pixels that moves a quarter of a pixel per frame.
fn moving_glow(pipeline: &str) -> Vec<f64> {
    let (nodes, rest) = pipeline.split_once("outputs: {").expect("a pipeline has outputs");
    let (_, tiers) = rest.split_once('}').expect("the section ends");
    let bloom = if nodes.contains("\"bloom\": ") { "bloom" } else { "glare" };
    let graph = graph(&format!("{nodes}outputs: {{ \"glow\": \"{bloom}\" }}{tiers}"));
    let run = Run::new(&graph);
    let mut sequence = Sequence::new(&run);
    let sums = (0..13).map(|frame| {
        let mut picture = light(2.0, 200.0, 0.25 * f64::from(frame));
        picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|x| x + 0.1));
        sequence.frame(&[("scene", &picture)], 0.0, frame == 0);
        sequence.output("glow").pixels.iter().map(|pixel| f64::from(pixel[0])).sum()
    });
    sums.skip(1).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn the_glow_of_a_moving_light_is_constant_in_built_in_pipelines() {
    for name in ["lynx.ron", "tsushima.ron"] {
        let now = text(name);
        assert!(now.contains("fireflies: Limit") && now.contains("filter: Binomial)"), "both are replaced");
        let weights = now
            .replace("fireflies: Limit", "fireflies: Keep")
            .replace("filter: Binomial)", "filter: Tap13, firefly: Groups)");
        let [before, after] = [weights, now].map(|pipeline| variation(&moving_glow(&pipeline)));
        println!("{name}: the glow varies by {:.1} %, with weights by {:.1} %", 100.0 * after, 100.0 * before);
        assert!(before > 0.3 && after < 0.05, "{name}: {before} {after}");
    }
    for (name, most) in [("hdr.ron", 0.02), ("mobile.ron", 0.02), ("cookbook.ron", 0.02), ("glare.ron", 0.08)] {
        let off = variation(&moving_glow(&text(name)));
        println!("{name}: the glow varies by {:.1} %", 100.0 * off);
        assert!(off < most, "{name}: {off}");
    }
}

/// A dark room with a window, and a floor with glints of a lamp; `sun` is the light of a disk in the window.
fn room(sun: f32) -> Picture {
    Picture::new(256, 144, |x, y| {
        let is_sun = (x as f32 - 70.0).hypot(y as f32 - 40.0) < 4.0;
        let is_window = (40..120).contains(&x) && (20..80).contains(&y);
        let is_glint = y > 100 && x % 16 == 3 && y % 8 < 2;
        let light = if is_sun {
            sun
        } else if is_window {
            6.0
        } else if is_glint {
            60.0
        } else {
            0.1
        };
        [light, 0.9 * light, 0.8 * light, 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_lens_flares_only_in_a_sun() {
    let rooms = [6.0, 20_000.0].map(room);
    let [with, without] = ["384.0", "65504.0"].map(|threshold| {
        let graph = changed("cinematic.ron", None, &[("flare.threshold", threshold)]);
        Run::new(&graph).shown(&rooms.each_ref())
    });
    let [window, sun] = [0, 1].map(|at: usize| {
        let pairs = with[at].pixels.iter().zip(&without[at].pixels);
        pairs.filter(|(a, b)| a[..3].iter().zip(*b).any(|(a, b)| (a - b).abs() > 2.5 / 255.0)).count()
    });
    assert_eq!(window, 0, "a window and glints");
    assert!(sun > 100, "a sun: {sun}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pixel_that_is_not_finite_changes_no_other() {
    let gray = Picture::new(120, 90, |_, _| [0.3, 0.3, 0.3, 1.0]);
    for name in sweep::some(["caracal.ron", "exposure.ron", "glare.ron", "lynx.ron", "tsushima.ron"], 2) {
        let graph = built_in(name, None);
        let numbers = [f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        let with = |number: f32, count: usize| {
            let mut bad = Picture::new(120, 90, |x, y| gray.at(x, y));
            (0..count).for_each(|at| bad.pixels[50 + at + 40 * 120][..3].fill(number));
            bad
        };
        let [one, two] = [1, 2].map(|count| numbers.map(|number| with(number, count)));
        let all: Vec<&Picture> = [&gray].into_iter().chain(&one).chain(&two).collect();
        let shown = Run::new(&graph).shown(&all);
        let is_clean = |at: usize| shown[at].pixels == shown[0].pixels;
        for (at, number) in numbers.into_iter().enumerate() {
            assert!(is_clean(1 + at), "{name}: one pixel with {number} changes the image");
            // Two infinite neighbors are light.
            assert_eq!(is_clean(4 + at), number != f32::INFINITY, "{name}: two pixels with {number}");
        }
    }
}

/// The number of pixels that change by more than two codes if one pixel of a gray image has the largest number.
fn changed_by_a_hot_pixel(graph: &Graph) -> usize {
    let gray = Picture::new(120, 90, |_, _| [0.2, 0.2, 0.2, 1.0]);
    let mut hot = Picture::new(120, 90, |x, y| gray.at(x, y));
    hot.pixels[50 + 40 * 120][..3].fill(65504.0);
    let run = Run::new(graph);
    // Without a frame before, nothing shows that the pixel was not there.
    let mut sequence = Sequence::new(&run);
    sequence.frame(&[("scene", &gray)], 0.0, true);
    let first = sequence.outputs().remove(0);
    sequence.frame(&[("scene", &hot)], 0.0, false);
    let second = sequence.outputs().remove(0);
    let pairs = first.pixels.iter().zip(&second.pixels);
    pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 2.5 / 255.0)).count()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pixel_of_the_largest_number_does_not_glow() {
    for name in sweep::some(["cookbook.ron", "lynx.ron", "mobile.ron", "tsushima.ron"], 2) {
        for tier in [None, Some("low")] {
            // Anti-aliasing dims the pixel and changes those beside it.
            let limited = changed_by_a_hot_pixel(&built_in(name, tier));
            assert!((1..=9).contains(&limited), "{name} {tier:?}: {limited} pixels change");
            let kept = changed_by_a_hot_pixel(&changed(name, tier, &[("bright.fireflies", "Keep")]));
            assert!(kept > 500, "{name} {tier:?}: {kept} pixels change without the limit");
        }
    }
}

/// A sky with a haze around a sun of four pixels.
fn sun() -> Picture {
    Picture::new(256, 256, |x, y| {
        let away = (x as f32 - 128.0).hypot(y as f32 - 128.0);
        let light = 0.4 + 4.0 * (-away / 24.0).exp() + if away < 4.0 { 20_000.0 } else { 0.0 };
        [light, 0.95 * light, 0.85 * light, 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn the_glare_of_a_sun_is_no_white_blob() {
    let [none, added, screened] = [("lit.strength", "0.0"), ("lit.blend", "Add"), ("lit.blend", "Screen")].map(|set| {
        let graph = changed("glare.ron", None, &[set]);
        let shown = Run::new(&graph).frame(&[("scene", &sun())]).remove(0);
        shown.pixels.iter().filter(|pixel| pixel[..3].iter().all(|x| *x > 250.5 / 255.0)).count()
    });
    println!("pixels above code 250: {none} without glare, {screened} screened, {added} added");
    assert!(none > 0 && screened < 3 * none && added > 4 * screened, "{none} {screened} {added}");
}

/// Diagonal lines of one pixel on a dark ground, `shift` pixels to the right.
fn diagonals([width, height]: [u32; 2], shift: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let light = if away_from_line(x, y, shift) == 0 { 8.0 } else { 0.02 };
        [light, light, light, 1.0]
    })
}

/// Pixels from a line along x.
fn away_from_line(x: u32, y: u32, shift: u32) -> u32 {
    (x + 1024 - y - shift) % 64
}

/// The mean code beside a line in each frame, while the lines move by a pixel a frame.
fn codes_beside_a_moving_diagonal(name: &str, size: [u32; 2], by_rows: When) -> Vec<f64> {
    let graph = built_in(name, None);
    let mut run = Run::new(&graph);
    run.options.row_downsample = by_rows;
    let mut sequence = Sequence::new(&run);
    let codes = (0..7).map(|shift| {
        sequence.frame(&[("scene", &diagonals(size, shift))], 0.0, shift == 0);
        let shown = sequence.output("display");
        let inside = (32..size[1] - 32).flat_map(|y| (32..size[0] - 32).map(move |x| (x, y)));
        let beside: Vec<f64> = inside
            .filter(|(x, y)| away_from_line(*x, *y, shift) == 6)
            .map(|(x, y)| 255.0 * f64::from(shown.at(x, y)[1]))
            .collect();
        beside.iter().sum::<f64>() / beside.len() as f64
    });
    // The history begins with the first frame.
    codes.skip(1).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "a figure for the log")]
fn the_glow_of_a_moving_diagonal_is_constant_at_every_size() {
    for (name, by_rows) in [
        ("lynx.ron", When::Always),
        ("lynx.ron", When::Never),
        ("caracal.ron", When::Always),
        ("glare.ron", When::Always),
        ("tsushima.ron", When::Always),
    ] {
        for size in sweep::some([[480, 268], [481, 268], [481, 269], [480, 269]], 1) {
            let codes = codes_beside_a_moving_diagonal(name, size, by_rows);
            let [least, most] =
                [codes.iter().copied().fold(255.0, f64::min), codes.iter().copied().fold(0.0, f64::max)];
            println!("{name} {size:?}: {least:.1} to {most:.1} codes");
            assert!(most - least <= 1.0, "{name} {size:?}: {codes:.1?}");
        }
    }
}
