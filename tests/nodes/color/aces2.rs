//! Aces2Output against OpenColorIO's values, and against its own evaluation in double precision.

use super::{Numbers, SIZES, light, picture, rgb, run, tolerance};
use crate::reference::math::{Rgb, largest};
use crate::support::gpu::Picture;
use crate::support::harness::{assert_close, image};
use afterimage_graph::check::NoFiles;
use afterimage_nodes::{Aces2Gamut, Aces2Output, MiddleGray};

/// A line of `tests/vectors/aces2.txt`: linear Rec.709, and the display's linear RGB in units of 100 cd/m2.
struct Vector {
    display: String,
    peak: f64,
    source: Rgb,
    shown: Rgb,
}

fn vectors() -> Vec<Vector> {
    let line = |line: &str| {
        let [display, numbers @ ..] = &line.split_whitespace().collect::<Vec<_>>()[..] else { panic!("{line}") };
        let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().unwrap()).collect();
        let [peak, r, g, b, shown @ ..] = &numbers[..] else { panic!("{line}") };
        let shown = shown.try_into().unwrap();
        Vector { display: (*display).to_owned(), peak: *peak, source: [*r, *g, *b], shown }
    };
    let text = include_str!("../../vectors/aces2.txt");
    text.lines().filter(|line| !line.starts_with('#')).map(line).collect()
}

fn gamut(display: &str) -> Aces2Gamut {
    *Aces2Gamut::ALL.iter().find(|gamut| gamut.name() == display).unwrap()
}

/// The transform with the exposure and the unit of OpenColorIO.
fn native(gamut: Aces2Gamut, peak: f64) -> Aces2Output {
    Aces2Output { gamut, peak: (peak / 100.0) as f32, white_nits: 100.0, middle_gray: MiddleGray::Native }
}

fn distance(a: Rgb, b: Rgb) -> f64 {
    largest([0, 1, 2].map(|channel| (a[channel] - b[channel]).abs()))
}

#[test]
fn the_evaluation_agrees_with_opencolorio() {
    let all = vectors();
    assert_eq!(all.len(), 800);
    for group in all.chunk_by(|a, b| a.display == b.display && a.peak == b.peak) {
        let (display, peak) = (&group[0].display, group[0].peak);
        let evaluate = native(gamut(display), peak).evaluator();
        for Vector { source, shown, .. } in group {
            let found = evaluate(*source);
            // OpenColorIO computes in f32; its values have six digits.
            let allowed = 1e-4 + 2e-5 * peak / 100.0;
            assert!(distance(found, *shown) < allowed, "{display} {peak}: {source:?} is {shown:?}, not {found:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_shader_agrees_with_opencolorio() {
    for group in vectors().chunk_by(|a, b| a.display == b.display && a.peak == b.peak) {
        let (display, peak) = (&group[0].display, group[0].peak);
        let input = Picture::new(group.len() as u32, 1, |x, _| {
            let [r, g, b] = group[x as usize].source.map(|channel| channel as f32);
            [r, g, b, 1.0]
        });
        let output = run("Exposed", &node(display, peak), &NoFiles, &input);
        for (Vector { source, shown, .. }, pixel) in group.iter().zip(&output.pixels) {
            let found = rgb(*pixel);
            assert!(distance(found, *shown) < 1e-3, "{display} {peak}: {source:?} is {shown:?}, not {found:?}");
        }
    }
}

fn node(display: &str, peak: f64) -> String {
    let peak = peak / 100.0;
    format!("Aces2Output(gamut: {display}, peak: {peak:?}, white_nits: 100.0, middle_gray: Native)")
}

/// Light of every saturation, from 2^-9 to 2^7.
pub(in crate::nodes) fn scene(size: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x0b5e_71c3_9d2f_4a61);
    picture(size, move |_| [0, 1, 2].map(|_| (16.0 * numbers.next() - 9.0).exp2()))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_shader_agrees_with_the_evaluation() {
    for (display, peak) in [("Rec709", 100.0), ("P3", 300.0), ("Rec2020", 10000.0)] {
        let evaluate = native(gamut(display), peak).evaluator();
        for size in SIZES {
            let input = scene(size);
            let output = run("Exposed", &node(display, peak), &NoFiles, &input);
            let expected = image(&input).map_rgb(&evaluate);
            let tolerance = tolerance(1e-4, 1e-4, "a chain of seven powers in f32, and a table of hues in f32");
            assert_close(&format!("{display} {peak}"), &output, &expected, &tolerance);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn middle_gray_is_matched_in_units_of_white() {
    let gray = Picture::new(1, 1, |_, _| [0.18, 0.18, 0.18, 1.0]);
    for rest in ["", "peak: 4.926, gamut: Rec2020", "peak: 5.0, white_nits: 120.0"] {
        let [r, g, b] = rgb(run("Exposed", &format!("Aces2Output({rest})"), &NoFiles, &gray).at(0, 0));
        assert!([r, g, b].iter().all(|x| (x - 0.18).abs() < 1e-4), "{rest}: {r} {g} {b}");
    }
    // As published: 10 cd/m2 for SDR.
    let native = rgb(run("Exposed", "Aces2Output(middle_gray: Native)", &NoFiles, &gray).at(0, 0));
    assert!((native[1] - 0.1).abs() < 1e-4, "{native:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_of_any_kind_stays_in_the_gamut() {
    let input = light([61, 37]);
    for (display, peak) in [("Rec709", 100.0), ("P3", 1000.0), ("Rec2020", 4000.0)] {
        let output = run("Exposed", &node(display, peak), &NoFiles, &input);
        let top = peak / 100.0;
        for (from, to) in input.pixels.iter().zip(&output.pixels) {
            let shown = rgb(*to);
            assert!(shown.iter().all(|x| (0.0..=1.0001 * top).contains(x)), "{from:?} became {shown:?}");
        }
        assert_eq!(rgb(output.at(1, 0)), [0.0; 3], "black");
        let white = rgb(output.at(3, 0));
        assert!(distance(white, [top; 3]) < 1e-3 * top, "the brightest gray is {white:?}");
    }
}
