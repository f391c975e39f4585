//! Local tone mapping and the Gaussian.

use std::sync::LazyLock;

use super::{Case, Op, array};
use crate::reference::gaussian::{linear_pairs, taps};
use crate::reference::image::{Image, center_uv, gray};
use crate::reference::local::{Grid, Range, Splat, grid_coordinate, scale, trilinear};

pub(super) const OPS: &[Op] = &[
    ("ltm_scale", |case| {
        let [l, base, contrast, detail] = ["l", "base", "C", "D"].map(|name| case.part_number(name));
        vec![scale(l, base, case.param("M"), contrast, detail)]
    }),
    ("grid_splat", splat),
    ("grid_slice_step", slice),
    ("gauss_taps", |case| taps(case.part_number("sigma"), case.part_number("radius") as usize)),
    ("linear_pairs", |case| linear_pairs(&case.numbers()).concat()),
];

fn range(case: &Case) -> Range {
    Range { low: case.param("lo"), high: case.param("hi") }
}

fn splat(case: &Case) -> Vec<f64> {
    let [x, y, l] = case.array();
    let [width, height] = array(&case.params["image"]).map(|n: f64| n as usize);
    let size = array(&case.params["grid"]).map(|n: f64| n as usize);
    let uv = center_uv(x as usize, y as usize, width, height);
    let listed = |(cell, weight): ([usize; 3], f64)| cell.map(|i| i as f64).into_iter().chain([weight]);
    let at = grid_coordinate(uv, l, size, range(case));
    trilinear(at, size).into_iter().flat_map(listed).collect()
}

/// The step image of the vectors: log2 luminance −4 in the left half and 2 in the right.
static STEP: LazyLock<Grid> = LazyLock::new(|| {
    let image = Image::new(8, 4, |x, _| gray(if x < 4 { 2.0_f64.powi(-4) } else { 4.0 }));
    let range = Range { low: -8.0, high: 8.0 };
    Grid::build(&image, [4, 2, 8], range, Splat::Trilinear).blurred([0.8; 3], [3; 3])
});

fn slice(case: &Case) -> Vec<f64> {
    let [x, y, l] = case.array();
    vec![STEP.base(center_uv(x as usize, y as usize, 8, 4), l, f64::NAN)]
}

#[test]
fn local_references_agree_with_the_vectors() {
    super::check(OPS);
}
