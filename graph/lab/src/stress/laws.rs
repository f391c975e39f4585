//! The laws that outputs must keep, and the invariants of kinds that decide which of them apply.

use afterimage_graph::check::Graph;
use afterimage_graph::color::LUMINANCE_REC709;
use afterimage_graph::image::{ColorState, Signedness, Size};
use afterimage_graph::node::Invariants;
use glam::DVec3;

use super::images::{Extreme, sanitized};
use super::render::OutputPixels;

/// The largest finite half float.
const MAX_HALF: f64 = 65504.0;
/// Below this half floats are subnormal, and devices may flush them to 0.
const MIN_NORMAL_HALF: f64 = 6.2e-5;

/// All invariants of images: those of a node that only makes values visible.
pub(crate) const ALL: Invariants = Invariants {
    constant: true,
    keeps_constant: true,
    symmetric: true,
    keeps_sum: true,
    monotone: true,
    non_negative: true,
    settles: true,
    is_exposure: false,
    of_color: true,
};

/// The invariants that hold for all nodes of a graph together; it gives an exposure if one of them does.
pub(crate) fn invariants(graph: &Graph) -> Invariants {
    let mut all = ALL;
    for node in &graph.nodes {
        let one = node.instance.invariants();
        all = Invariants {
            constant: all.constant && one.constant,
            keeps_constant: all.keeps_constant && one.keeps_constant,
            symmetric: all.symmetric && one.symmetric,
            keeps_sum: all.keeps_sum && one.keeps_sum,
            monotone: all.monotone && one.monotone,
            non_negative: all.non_negative && one.non_negative,
            settles: all.settles && one.settles,
            is_exposure: all.is_exposure || one.is_exposure,
            of_color: all.of_color && one.of_color,
        };
    }
    all
}

/// The largest difference of two equal numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// Relative to the larger one.
    pub(crate) relative: f64,
    /// Absolute, added to the relative part.
    pub(crate) absolute: f64,
}

impl Tolerance {
    pub(crate) const NONE: Self = Self { relative: 0.0, absolute: 0.0 };
    /// Four units in the last place of a half float.
    pub(crate) const HALF: Self = Self { relative: 4.0 / 1024.0, absolute: MIN_NORMAL_HALF };

    /// Adds what filters leak of the brightest pixel. Coordinates are rounded, more on the right than on the left and
    /// not in the same way for every texture path, so a tap between two texels weights them slightly differently.
    pub(crate) fn leaking(self, shown: &OutputPixels) -> Self {
        const LEAK: f64 = 2e-6;
        let brightest =
            shown.pixels.iter().flat_map(|pixel| &pixel[..3]).fold(0.0_f64, |most, x| most.max(f64::from(*x)));
        Self { absolute: self.absolute + LEAK * brightest, ..self }
    }

    fn accepts(self, a: f32, b: f32) -> bool {
        let (a, b) = (f64::from(a), f64::from(b));
        a == b || (a - b).abs() <= self.relative * a.abs().max(b.abs()) + self.absolute
    }
}

/// A pixel and its position, for messages.
fn at(shown: &OutputPixels, index: usize) -> String {
    let width = shown.size.width as usize;
    format!("{:?} at ({}, {}) of `{}`", shown.pixels[index], index % width, index / width, shown.name)
}

pub(crate) fn finite(shown: &OutputPixels) -> Option<String> {
    let index = shown.pixels.iter().position(|pixel| pixel.iter().any(|x| !x.is_finite()))?;
    Some(format!("not finite: {}", at(shown, index)))
}

/// True if a scene-linear color has a luminance of 0 or more, up to the rounding to half floats.
fn has_luminance(pixel: &[f32; 4]) -> bool {
    let [r, g, b, _] = pixel.map(f64::from);
    let luminance = DVec3::new(r, g, b).dot(LUMINANCE_REC709.into());
    luminance >= -2e-3 * r.abs().max(g.abs()).max(b.abs()) - MIN_NORMAL_HALF
}

/// Colors are in the range of their state. Scene-linear color may have negative components, but no negative luminance.
pub(crate) fn in_range(shown: &OutputPixels, non_negative: bool) -> Option<String> {
    let signedness = shown.state.signedness();
    if signedness == Signedness::Signed || shown.pixels.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    let is_extended = signedness == Signedness::Extended;
    let low = if non_negative && !is_extended { 0.0 } else { -MAX_HALF };
    let high = shown.limit.unwrap_or(MAX_HALF);
    // One rounding of a 32-bit float above the limit is still at the limit.
    let high = high * (1.0 + 1e-6);
    let is_dark = |pixel: &[f32; 4]| is_extended && non_negative && !has_luminance(pixel);
    let outside =
        |pixel: &[f32; 4]| is_dark(pixel) || pixel[..3].iter().any(|x| !(low..=high).contains(&f64::from(*x)));
    let index = shown.pixels.iter().position(outside)?;
    Some(format!("out of range for {}: {}", shown.state.name(), at(shown, index)))
}

/// The first pixel in which two outputs differ.
pub(crate) fn different(a: &OutputPixels, b: &OutputPixels, tolerance: Tolerance) -> Option<String> {
    if a.size != b.size {
        return Some(format!("`{}` is {} and not {}", a.name, a.size, b.size));
    }
    let differ = |(x, y): (&[f32; 4], &[f32; 4])| (0..4).any(|c| !tolerance.accepts(x[c], y[c]));
    let index = a.pixels.iter().zip(&b.pixels).position(differ)?;
    Some(format!("{}, not {:?}", at(a, index), b.pixels[index]))
}

/// A tested invariant: its name, and how it is violated.
pub(crate) type Tested = (&'static str, Option<String>);

/// Tests the invariants of the graph on a still image.
pub(crate) fn tested(shown: &OutputPixels, image: Extreme, size: Size, invariants: &Invariants) -> Vec<Tested> {
    // Sums of data in a grid depend on the number of pixels in a cell.
    if finite(shown).is_some() || shown.state == ColorState::Data {
        return Vec::new();
    }
    let given = sanitized(&image.pixels(size), size, shown.state.signedness());
    // Squares of two columns begin at the left border, so that the last column is alone where the width is odd.
    let is_of_squares = size.width % 2 == 1 && shown.size.width == size.width.div_ceil(2);
    let can_be_symmetric = invariants.symmetric && !is_of_squares;
    let checks = [
        (invariants.constant && is_constant(&given)).then(|| ("constant", constant(shown))),
        (invariants.keeps_constant && is_constant(&given)).then(|| ("energy", kept(shown, given[0]))),
        (can_be_symmetric && is_symmetric(&given, size)).then(|| ("symmetric", symmetric(shown))),
        (invariants.monotone && image.name == "ramp" && shown.size == size).then(|| ("monotone", rising(shown))),
        (invariants.keeps_sum && is_inside(shown, &given, size)).then(|| ("energy", spread(shown, &given))),
    ];
    checks.into_iter().flatten().collect()
}

fn is_constant(pixels: &[[f32; 4]]) -> bool {
    pixels.iter().all(|pixel| *pixel == pixels[0])
}

fn mirrored(pixels: &[[f32; 4]], size: Size) -> Vec<[f32; 4]> {
    pixels.chunks_exact(size.width as usize).flat_map(|row| row.iter().rev()).copied().collect()
}

fn is_symmetric(pixels: &[[f32; 4]], size: Size) -> bool {
    mirrored(pixels, size) == pixels
}

fn constant(shown: &OutputPixels) -> Option<String> {
    let first = OutputPixels { pixels: vec![shown.pixels[0]; shown.pixels.len()], ..shown.clone() };
    different(shown, &first, Tolerance::HALF).map(|what| format!("a constant image does not stay constant: {what}"))
}

fn kept(shown: &OutputPixels, given: [f32; 4]) -> Option<String> {
    let same = OutputPixels { pixels: vec![given; shown.pixels.len()], ..shown.clone() };
    different(shown, &same, Tolerance::HALF).map(|what| format!("a constant becomes another: {what}"))
}

fn symmetric(shown: &OutputPixels) -> Option<String> {
    let other = OutputPixels { pixels: mirrored(&shown.pixels, shown.size), ..shown.clone() };
    let tolerance = Tolerance::HALF.leaking(shown);
    different(shown, &other, tolerance).map(|what| format!("a symmetric image does not stay symmetric: {what}"))
}

/// The ramp rises along the longer side, so the output must rise, up to rounding. Of colors outside of Rec.709,
/// negative components fall as the others rise.
fn rising(shown: &OutputPixels) -> Option<String> {
    let step = if shown.size.width >= shown.size.height { 1 } else { shown.size.width as usize };
    let length = shown.size.width.max(shown.size.height) as usize;
    let falls = |i: usize| {
        let (before, after) = (shown.pixels[(i - 1) * step], shown.pixels[i * step]);
        (0..3).any(|c| f64::from(after[c]) < f64::from(before[c]) * (1.0 - 2.0 / 1024.0) - 1e-6 && before[c] > 0.0)
    };
    let index = (1..length).find(|i| falls(*i))? * step;
    Some(format!("more light becomes less: {} after {:?}", at(shown, index), shown.pixels[index - step]))
}

/// True if the image and the output are black at the border.
fn is_inside(shown: &OutputPixels, given: &[[f32; 4]], size: Size) -> bool {
    is_dark_at_border(&shown.pixels, shown.size) && is_dark_at_border(given, size)
}

fn is_dark_at_border(pixels: &[[f32; 4]], size: Size) -> bool {
    let (width, height) = (size.width as usize, size.height as usize);
    let on_border =
        |i: usize| i.is_multiple_of(width) || i % width == width - 1 || i / width == 0 || i / width == height - 1;
    (0..pixels.len()).all(|i| !on_border(i) || pixels[i][0] == 0.0)
}

/// The mean is kept. A pixel of a smaller output stands for several of the image.
fn spread(shown: &OutputPixels, given: &[[f32; 4]]) -> Option<String> {
    let mean = |pixels: &[[f32; 4]]| pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64;
    let (before, after) = (mean(given), mean(&shown.pixels));
    let is_changed = (before - after).abs() > 0.005 * before;
    is_changed.then(|| format!("the sum of the light of `{}` becomes {} times as much", shown.name, after / before))
}

#[cfg(test)]
mod tests {
    use afterimage_graph::image::{ColorState, Size};

    use super::super::images::Extreme;
    use super::super::render::OutputPixels;
    use super::{ALL, Tolerance, different, finite, in_range, tested};

    fn picture(values: &[f32], width: u32) -> OutputPixels {
        let pixels: Vec<[f32; 4]> = values.iter().map(|x| [*x, *x, *x, 1.0]).collect();
        let size = Size::new(width, values.len() as u32 / width);
        OutputPixels { name: "result".into(), state: ColorState::Encoded, limit: Some(1.0), size, pixels }
    }

    #[test]
    fn numbers_out_of_order_are_named_with_their_place() {
        assert_eq!(finite(&picture(&[0.0, 1.0], 2)), None);
        let found = finite(&picture(&[0.0, 1.0, 1.0, f32::NAN], 2));
        assert_eq!(found.as_deref(), Some("not finite: [NaN, NaN, NaN, 1.0] at (1, 1) of `result`"));
        assert_eq!(in_range(&picture(&[0.0, 1.0], 2), true), None);
        assert!(in_range(&picture(&[0.0, 1.1], 2), true).is_some());
        assert!(in_range(&picture(&[-0.1, 1.0], 2), true).is_some_and(|what| what.contains("(0, 0)")));
        assert_eq!(in_range(&picture(&[-0.1, 1.0], 2), false), None);
        let (a, b) = (picture(&[0.5, 0.25], 2), picture(&[0.5, 0.2502], 2));
        assert_eq!(different(&a, &b, Tolerance::HALF), None);
        assert!(different(&a, &b, Tolerance::NONE).is_some());
    }

    #[test]
    fn violated_invariants_are_found() {
        let size = Size::new(5, 3);
        let violations = |name: &str, values: &[f32]| {
            let image = Extreme::named(name).expect("an image of that name");
            let looked_at = tested(&picture(values, 5), image, size, &ALL);
            looked_at.into_iter().filter_map(|(_, wrong)| wrong).collect::<Vec<_>>()
        };
        assert_eq!(violations("white", &[1.0; 15]), Vec::<String>::new());
        assert!(violations("white", &[0.5; 15])[0].starts_with("a constant becomes another"));
        let mut uneven = [1.0; 15];
        uneven[3] = 0.9;
        let of_uneven = violations("white", &uneven);
        assert!(of_uneven[0].starts_with("a constant image does not stay"), "{of_uneven:?}");
        assert!(of_uneven.iter().any(|what| what.starts_with("a symmetric image")), "{of_uneven:?}");
        let falling: Vec<f32> = (0..15).map(|i| 1.0 - (i % 5) as f32 * 0.1).collect();
        assert!(violations("ramp", &falling)[0].starts_with("more light becomes less"));
        let mut faint = [0.0; 15];
        faint[7] = 60_000.0;
        assert!(violations("firefly", &faint).iter().any(|what| what.starts_with("the sum of")));
    }
}
