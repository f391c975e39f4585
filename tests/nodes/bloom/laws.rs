//! Laws of a glow, in every built-in pipeline that has one: it moves with its light, does not swell at a border, and is
//! there in the first frame.

use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;

use crate::support::gpu::{Picture, Repository, Run, graph, pipelines, registry, tiers as known_tiers};
use crate::support::sequence::Sequence;
use crate::support::sweep;

/// The pipelines with a composite of bloom, `lit`, and an image of the composite's color state.
const GLOWING: [(&str, &str); 8] = [
    ("caracal.ron", "scene"),
    ("cookbook.ron", "exposed"),
    ("hdr.ron", "exposed"),
    ("lynx.ron", "exposed"),
    ("mobile.ron", "seen"),
    ("tsushima.ron", "exposed"),
    ("tsushima-night.ron", "exposed"),
    ("cinematic.ron", "exposed"),
];

const SIDE: u32 = 192;

/// A pipeline that shows the glow alone, as its composite adds it.
fn glow_of(name: &str, image: &str, tier: Option<&str>) -> Graph {
    let text = format!(
        r#"Pipeline(
    extends: "{name}",
    nodes: {{ "dark": Extract(source: "{image}", threshold: 65504.0) }},
    outputs: {{ "glow": "lit" }},
)"#
    );
    let path = pipelines().join("glow.ron");
    let document = parse(&path.to_string_lossy(), &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let sets = vec![("lit.base".into(), r#""dark""#.into())];
    let options = CheckOptions { tier: tier.map(str::to_owned), sets, loader: &Repository };
    check(&document, &registry(), &options).unwrap_or_else(|errors| panic!("{name}: {errors:?}")).0
}

/// The glow of the first frame with each of these pictures.
fn glows(graph: &Graph, pictures: &[Picture]) -> Vec<Picture> {
    let inputs: Vec<[(&str, &Picture); 1]> = pictures.iter().map(|picture| [("scene", picture)]).collect();
    let inputs: Vec<&[(&str, &Picture)]> = inputs.iter().map(<[_; 1]>::as_slice).collect();
    let outputs = Run::new(graph).first_frames(&inputs);
    outputs.into_iter().map(|mut outputs| outputs.pop().expect("the glow is the last output")).collect()
}

/// A dark picture with a square light; alpha is the emission.
fn square(side: u32, [left, top]: [u32; 2]) -> Picture {
    Picture::new(SIDE, SIDE, |x, y| {
        let is_light = (left..left + side).contains(&x) && (top..top + side).contains(&y);
        if is_light { [20.0, 20.0, 20.0, 1.0] } else { [0.05, 0.05, 0.05, 0.0] }
    })
}

/// The glow within `margin` pixels of a light, relative to it.
fn around(glow: &Picture, side: u32, margin: u32, [left, top]: [u32; 2]) -> Vec<f64> {
    let rows = top - margin..top + side + margin;
    rows.flat_map(|y| (left - margin..left + side + margin).map(move |x| (x, y)))
        .map(|(x, y)| f64::from(glow.at(x, y)[1]))
        .collect()
}

/// The largest ratio between the glows at a place relative to the light, where it is a tenth of the brightest or more.
fn swing(graph: &Graph, side: u32) -> f64 {
    let places: Vec<[u32; 2]> = (0..8).map(|phase| [80 + phase, 80 + 3 * phase % 8]).collect();
    let pictures: Vec<Picture> = places.iter().map(|place| square(side, *place)).collect();
    let shown = glows(graph, &pictures);
    let glows: Vec<Vec<f64>> = shown.iter().zip(&places).map(|(glow, place)| around(glow, side, 12, *place)).collect();
    let brightest = glows[0].iter().copied().fold(0.0, f64::max);
    assert!(brightest > 0.0, "a light glows");
    let at = |index: usize| glows.iter().map(move |glow| glow[index]);
    (0..glows[0].len())
        .filter(|index| glows[0][*index] > 0.1 * brightest)
        .map(|index| at(index).fold(0.0, f64::max) / at(index).fold(f64::INFINITY, f64::min))
        .fold(1.0, f64::max)
}

/// Lights of 1 to 8 pixels at eight phases across and down. Their levels are those of a frame of 192 lines, where the
/// finest has the largest share.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_glow_does_not_pulse_when_its_light_moves_by_a_pixel() {
    let tiers = [None, Some("ultra"), Some("low")];
    let cases = GLOWING.into_iter().flat_map(|(name, image)| tiers.map(|tier| (name, image, tier)));
    let cases =
        cases.filter(|(name, _, tier)| tier.is_none_or(|tier| known_tiers(name).iter().any(|known| known == tier)));
    for (name, image, tier) in sweep::some(cases, 8) {
        let graph = glow_of(name, image, tier);
        for side in [1, 2, 3, 8] {
            let found = swing(&graph, side);
            let bound = match (tier, side) {
                (_, 1) => 1.1,
                // Halvings by `Tap9`, and packed floats.
                (Some("low"), _) => 1.07,
                _ => 1.05,
            };
            assert!(found < bound, "{name} {tier:?}: the glow of {side} pixels swings by {found:.3}");
        }
    }
}

/// The glow to the right of a light of eight pixels.
fn beside(glow: &Picture, [left, top]: [u32; 2]) -> [f64; 3] {
    [2, 8, 16].map(|away| f64::from(glow.at(left + 8 + away, top + 4)[1]))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_glow_at_the_border_is_that_of_the_middle() {
    for (name, image) in GLOWING {
        if name == "caracal.ron" {
            // Its Gaussian returns the border beyond it.
            continue;
        }
        let graph = glow_of(name, image, None);
        let places = [[64, 64], [0, 64], [64, 0], [0, 0], [0, 184]];
        let pictures = places.map(|place| square(8, place));
        let shown = glows(&graph, &pictures);
        let middle = beside(&shown[0], places[0]);
        for (glow, place) in shown.iter().zip(places).skip(1) {
            for (found, wanted) in beside(glow, place).into_iter().zip(middle) {
                let ratio = found / wanted;
                assert!((0.95..1.2).contains(&ratio), "{name}, light at {place:?}: {ratio:.3} of that in the middle");
            }
        }
    }
}

/// Light that is mixed in is a mean: a flat picture stays flat, at any size.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_flat_picture_stays_flat_where_its_bloom_is_mixed_in() {
    let graph = graph(
        r#"Pipeline(inputs: { "scene": Color }, outputs: { "out": "out" }, nodes: {
            "bright": Extract(source: "scene", method: All),
            "mips": Downsample(source: "bright", levels: 5),
            "bloom": Upsample(source: "mips", blend: Add),
            "out": Composite(base: "scene", bloom: "bloom", blend: Mix, strength: 0.7),
        })"#,
    );
    let pictures = [[1, 1], [1, 7], [9, 1], [2, 2], [37, 61], [180, 320], [480, 270]]
        .map(|[width, height]| Picture::new(width, height, |_, _| [0.5, 0.5, 0.5, 1.0]));
    for shown in Run::new(&graph).shown(&pictures.each_ref()) {
        let off = shown.pixels.iter().map(|pixel| (pixel[1] - 0.5).abs()).fold(0.0, f32::max);
        assert!(off < 5e-4, "{}x{}: {off}", shown.width, shown.height);
    }
}

/// The sum of the glow in each frame; the third one is a cut.
fn energies(graph: &Graph, frames: &[Picture]) -> Vec<f64> {
    let run = Run::new(graph);
    let mut sequence = Sequence::new(&run);
    let sums = frames.iter().enumerate().map(|(index, frame)| {
        sequence.frame(&[("scene", frame)], 0.0, index == 0 || index == 3);
        sequence.output("glow").pixels.iter().map(|pixel| f64::from(pixel[1])).sum()
    });
    sums.collect()
}

/// Pictures of a light of one pixel that moves by so many pixels a frame.
fn spark(step: [u32; 2]) -> Vec<Picture> {
    (0..6).map(|frame| square(1, [60 + step[0] * frame, 60 + step[1] * frame])).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_lamp_of_one_pixel_glows_in_every_frame() {
    for (name, image) in GLOWING {
        let graph = glow_of(name, image, None);
        for step in [[0, 0], [1, 0], [0, 1], [3, 0], [7, 5]] {
            let sums = energies(&graph, &spark(step));
            let mean = sums.iter().sum::<f64>() / sums.len() as f64;
            let is_even = sums.iter().all(|sum| (sum / mean - 1.0).abs() < 0.05);
            assert!(mean > 0.0 && is_even, "{name}, {step:?} pixels a frame: {sums:.3?}");
        }
    }
}
