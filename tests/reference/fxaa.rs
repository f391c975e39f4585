//! FXAA 3.11 for quality (Lottes, NVIDIA, 2009 to 2011), as published: the search, the offset and the subpixel part.

use super::color::luminance;
use super::image::{Image, rgb};

/// The published steps of the presets 39, 25 and 12, from one read to the next. An edge without an end is as long as
/// all of them.
pub(crate) const STEPS: [&[f64]; 3] = [
    &[1.0, 1.0, 1.0, 1.0, 1.0, 1.5, 2.0, 2.0, 2.0, 2.0, 4.0, 8.0],
    &[1.0, 1.5, 2.0, 2.0, 2.0, 2.0, 4.0, 8.0],
    &[1.0, 1.5, 2.0, 4.0, 12.0],
];

pub(crate) struct Fxaa {
    pub(crate) subpixel: f64,
    pub(crate) threshold: f64,
    pub(crate) floor: f64,
    pub(crate) steps: &'static [f64],
    /// True if the image is linear light.
    pub(crate) is_light: bool,
}

/// An edge: the axis along it, the side of its other pixel, its mean brightness, and the contrast across it.
struct Edge {
    along: [f64; 2],
    across: [f64; 2],
    middle: f64,
    gradient: f64,
}

impl Fxaa {
    fn brightness(&self, pixel: [f64; 4]) -> f64 {
        let y = luminance(rgb(pixel)).max(0.0);
        if self.is_light { y.sqrt() } else { y }
    }

    pub(crate) fn apply(&self, image: &Image) -> Image {
        Image::new(image.width, image.height, |x, y| self.pixel(image, x as i64, y as i64))
    }

    fn pixel(&self, image: &Image, x: i64, y: i64) -> [f64; 4] {
        let at = |i: i64, j: i64| self.brightness(image.texel(x + i, y + j));
        let cross = [at(0, 0), at(0, -1), at(0, 1), at(-1, 0), at(1, 0)];
        let high = cross.iter().copied().fold(0.0, f64::max);
        let low = cross.iter().copied().fold(f64::INFINITY, f64::min);
        if high - low < self.floor.max(high * self.threshold) {
            return image.texel(x, y);
        }
        let corners = [at(-1, -1), at(1, -1), at(-1, 1), at(1, 1)];
        let mean = (2.0 * cross[1..].iter().sum::<f64>() + corners.iter().sum::<f64>()) / 12.0;
        let share = ((mean - cross[0]).abs() / (high - low)).clamp(0.0, 1.0);
        let subpixel = (share * share * (3.0 - 2.0 * share)).powi(2) * self.subpixel;
        let edge = edge(at);
        let place = [x as f64 + 0.5, y as f64 + 0.5];
        let offset = self.offset(image, place, &edge, cross[0]).max(subpixel);
        image.tap(uv(image, place, edge.across, offset))
    }

    /// The distance of the end of an edge, and the difference of the brightness that was read last.
    fn end(&self, image: &Image, start: [f64; 2], edge: &Edge, side: f64) -> (f64, f64) {
        let (mut distance, mut difference) = (0.0, 0.0);
        for (index, step) in self.steps.iter().enumerate() {
            distance += step;
            if index + 1 == self.steps.len() {
                break;
            }
            difference = self.brightness(image.tap(uv(image, start, edge.along, side * distance))) - edge.middle;
            if difference.abs() >= 0.25 * edge.gradient {
                break;
            }
        }
        (distance, difference)
    }

    fn offset(&self, image: &Image, [x, y]: [f64; 2], edge: &Edge, center: f64) -> f64 {
        let start = [x + 0.5 * edge.across[0], y + 0.5 * edge.across[1]];
        let [first, second] = [-1.0, 1.0].map(|side| self.end(image, start, edge, side));
        let nearest = first.0.min(second.0);
        let is_good = |(distance, difference): (f64, f64)| {
            distance <= nearest && (difference < 0.0) != (center - edge.middle < 0.0)
        };
        if is_good(first) || is_good(second) { 0.5 - nearest / (first.0 + second.0) } else { 0.0 }
    }
}

fn uv(image: &Image, [x, y]: [f64; 2], [dx, dy]: [f64; 2], distance: f64) -> [f64; 2] {
    [(x + dx * distance) / image.width as f64, (y + dy * distance) / image.height as f64]
}

fn edge(at: impl Fn(i64, i64) -> f64) -> Edge {
    let bend = |a: f64, b: f64, c: f64| (a + c - 2.0 * b).abs();
    let lines = [(-1, 1.0), (0, 2.0), (1, 1.0)];
    let rows: f64 = lines.iter().map(|&(i, weight)| weight * bend(at(i, -1), at(i, 0), at(i, 1))).sum();
    let columns: f64 = lines.iter().map(|&(j, weight)| weight * bend(at(-1, j), at(0, j), at(1, j))).sum();
    // At the corner of an area both are equal but for rounding.
    let is_row = 1.001 * rows >= columns;
    let center = at(0, 0);
    let [before, after] = if is_row { [at(0, -1), at(0, 1)] } else { [at(-1, 0), at(1, 0)] };
    let is_before = (before - center).abs() >= (after - center).abs();
    let (other, side) = if is_before { (before, -1.0) } else { (after, 1.0) };
    let (along, across) = if is_row { ([1.0, 0.0], [0.0, side]) } else { ([0.0, 1.0], [side, 0.0]) };
    Edge { along, across, middle: 0.5 * (other + center), gradient: (other - center).abs() }
}

#[test]
fn the_published_code_makes_the_same_of_a_picture() {
    // Exact numbers: in others, rounding decides whether the corner of an area is part of a row or of a column. Where
    // both are alike within a thousandth, here it is a row.
    let image = Image::new(32, 32, |x, y| [f64::from(code(x as i32, y as i32)) / 1024.0; 4]);
    let text = include_str!("../vectors/fxaa.txt").lines().filter(|line| !line.starts_with('#'));
    let lines: Vec<&str> = text.collect();
    for (steps, preset) in STEPS.into_iter().zip(lines.chunks(33)) {
        let fxaa = Fxaa { subpixel: 0.5, threshold: 0.125, floor: 0.0312, steps, is_light: false };
        let found = fxaa.apply(&image);
        let wanted = preset[1..].iter().flat_map(|row| row.split(' ').map(|x| x.parse::<f64>().expect("a number")));
        let (mut changed, mut off) = (0, 0);
        for ((wanted, found), before) in wanted.zip(&found.pixels).zip(&image.pixels) {
            off += u32::from((found[0] - wanted).abs() > 1e-6);
            changed += u32::from(found[0] != before[0]);
        }
        assert!(changed > 200 && off <= 1, "{}: {off} of {changed} pixels differ", preset[0]);
    }
}

/// Edges in several directions, a disk and thin lines, with a little noise.
fn code(x: i32, y: i32) -> i32 {
    let mut code = if 9 * y > 2 * x + 130 { 200 } else { 50 };
    if 7 * x > y + 140 {
        code = 230 - code / 2;
    }
    if (x - 12).pow(2) + (y - 7).pow(2) < 30 {
        code = 140;
    }
    if x == 20 && y % 7 < 5 {
        code = 90;
    }
    4 * code + (3 * x + 5 * y + x * y) % 6
}

#[test]
fn a_step_of_an_edge_becomes_a_ramp() {
    // An edge that falls by one row every eight pixels.
    let image = Image::new(32, 12, |x, y| [if y < 3 + x / 8 { 0.2 } else { 0.8 }; 4]);
    let fxaa = Fxaa { subpixel: 0.0, threshold: 0.125, floor: 0.03, steps: STEPS[0], is_light: false };
    let smooth = fxaa.apply(&image);
    let row: Vec<f64> = (8..16).map(|x| smooth.texel(x, 3)[0]).collect();
    // The first four pixels behind the step are mixed with the row below, less from one to the next.
    assert!(row[..4].windows(2).all(|pair| pair[0] > pair[1]) && row[0] > 0.4 && row[6] == 0.2, "{row:?}");
}
