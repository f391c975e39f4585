//! Bloom, its filters and glare.

use super::{Case, Op, array, flat};
use crate::reference::bloom::{
    Conserving, composite_add, composite_lerp, conserving_factor, gate_weight, glare, knee_weight, lerp_weights,
    level_sizes, select_emissive, unreal_weights,
};
use crate::reference::color::luminance;
use crate::reference::image::{Image, gray};
use crate::reference::math::{Rgb, largest};
use crate::reference::resample::{Down, downsample, karis_average};

pub(super) const OPS: &[Op] = &[
    ("knee_weight_x_b", knee),
    ("knee_weight_k0", knee),
    ("gate_weight", |case| vec![gate_weight(case.number(), case.param("t"), case.param("k"))]),
    // The vectors exclude the threshold. The kind includes it, so that its default of 1 selects a mask of 1.
    ("select_emissive", |case| {
        select_emissive(array(case.part("rgba")), case.part_number("thr").next_up(), 1.0).to_vec()
    }),
    ("karis_average", |case| karis_average(&samples(case), largest).to_vec()),
    ("karis_average_luma", |case| karis_average(&samples(case), luminance).to_vec()),
    ("downsample_4x4_ramp", |case| {
        let ramp = Image::new(4, 4, |x, y| gray((4 * y + x) as f64));
        reds(&downsample(&ramp, [2, 2], filter(case.word())))
    }),
    ("downsample_kernel_2d", kernel),
    ("bloom_levels", |case| {
        let [width, height, count] = case.array().map(|n: f64| n as usize);
        level_sizes(width, height, count).concat().iter().map(|&n| n as f64).collect()
    }),
    ("bloom_chain_weights", |case| match super::word(case.part("mode")) {
        "lerp" => lerp_weights(case.part_number("r"), case.part_number("L") as usize),
        _ => unreal_weights(case.part_number("radius")).to_vec(),
    }),
    ("bevy_style_blend", |case| {
        let [mip, last] = case.array();
        vec![conserving_factor(mip, last, &NATURAL)]
    }),
    ("bloom_composite", |case| {
        let (scene, bloom) = (case.part_rgb("scene"), case.part_rgb("bloom"));
        let composite = match super::word(case.part("mode")) {
            "lerp" => composite_lerp,
            _ => composite_add,
        };
        composite(scene, bloom, case.part_number("s")).to_vec()
    }),
    ("glare_extract", |case| glare(case.rgb(), 1.0).to_vec()),
];

const NATURAL: Conserving = Conserving { intensity: 0.15, low_boost: 0.7, low_curvature: 0.95, high_pass: 1.0 };

fn knee(case: &Case) -> Vec<f64> {
    let brightness = case.number();
    vec![brightness * knee_weight(brightness, case.param("t"), case.param("k"))]
}

fn samples(case: &Case) -> Vec<Rgb> {
    flat(case.input).chunks(3).map(|s| [s[0], s[1], s[2]]).collect()
}

fn filter(name: &str) -> Down {
    match name {
        "box2x2" => Down::Box,
        "tap4_box4x4" => Down::FourTap,
        "tap9_tent" => Down::NineTap,
        "tap13_cod" => Down::ThirteenTap,
        other => panic!("no filter is called `{other}`"),
    }
}

/// The weights of source texels in one destination texel, found by halving images of one bright
/// texel each.
fn kernel(case: &Case) -> Vec<f64> {
    let filter = filter(case.word());
    let side = if filter == Down::ThirteenTap { 6 } else { 4 };
    let weight = |x, y| {
        let spot = Image::new(12, 12, |i, j| gray(if (i, j) == (x, y) { 1.0 } else { 0.0 }));
        downsample(&spot, [6, 6], filter).texel(2, 2)[0]
    };
    // Destination texel 2 lies on the border of source texels 4 and 5.
    let places = 5 - side / 2..5 + side / 2;
    places.clone().flat_map(|y| places.clone().map(move |x| weight(x, y))).collect()
}

fn reds(image: &Image) -> Vec<f64> {
    image.pixels.iter().map(|pixel| pixel[0]).collect()
}

#[test]
fn bloom_references_agree_with_the_vectors() {
    super::check(OPS);
}
