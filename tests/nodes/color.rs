//! The tone and color kinds on the GPU, compared with their CPU references.

pub(super) mod aces2;
mod curves;
mod files;
mod gamut;
mod grade;
mod hue;
pub(super) mod lut;
pub(super) mod noise;
mod transfer;

use std::sync::Arc;

use afterimage_graph::check::{Loader, NoFiles};

use crate::reference::math::Rgb;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, image};
use crate::support::numbers::Numbers;

/// One texel, fewer texels than a workgroup, odd sides that no workgroup divides.
pub(super) const SIZES: [[u32; 2]; 3] = [[1, 1], [2, 3], [61, 37]];

/// The largest half float.
const LARGEST: f64 = 65504.0;

pub(super) const ARITHMETIC: Tolerance = tolerance(1e-6, 2e-6, "rounding of sums and products in f32");
pub(super) const TRANSCENDENTAL: Tolerance = tolerance(2e-6, 1e-5, "accuracy of powers and logarithms in f32");

/// A tolerance relative to the largest channel of a pixel. The classes are those of the test vectors.
pub(super) const fn tolerance(absolute: f64, relative: f64, reason: &'static str) -> Tolerance {
    Tolerance { absolute, relative, of: Scale::Pixel, reason }
}

/// Colors at which tone curves have been wrong before.
const SPECIAL: [Rgb; 16] = [
    [0.18; 3],
    [0.0; 3],
    [1.0; 3],
    [LARGEST; 3],
    [1e-30; 3],
    [5.96046448e-8, 6.10351562e-5, 0.0],
    [LARGEST, 0.0, 0.0],
    [0.0, LARGEST, 1e-6],
    [0.0, 0.0, LARGEST],
    [1.0, 0.1, 0.02],
    [0.02, 0.4, 4.0],
    [8.0; 3],
    [16.0, 0.5, 0.1],
    [0.0, 0.0, 10.0],
    [0.001, 0.002, 0.0005],
    [0.22, 0.532, 0.76],
];

/// The special colors, then light from 2^-14 to the largest half float in every saturation. Alpha is any number.
pub(super) fn light([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let mut random = move || (30.0 * numbers.next() - 14.0).exp2();
    picture([width, height], move |index| SPECIAL.get(index).copied().unwrap_or_else(|| [random(), random(), random()]))
}

/// Colors from 0 to 1, black and white among them.
pub(super) fn unit([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    let corner = |index: usize| [0, 1, 2].map(|channel| f64::from((index >> channel & 1) as u8));
    let mut random = move || numbers.next().powi(2);
    picture([width, height], move |index| if index < 8 { corner(index) } else { [random(), random(), random()] })
}

pub(super) fn picture([width, height]: [u32; 2], mut color: impl FnMut(usize) -> Rgb) -> Picture {
    Picture::new(width, height, |x, y| {
        let [r, g, b] = color((x + y * width) as usize).map(|v| v.min(LARGEST) as f32);
        [r, g, b, (x % 5) as f32 * 0.3]
    })
}

/// One node whose port `source` reads the input.
fn on_source(node: &str) -> String {
    format!("\"result\": {}", node.replacen('(', "(source: \"in\", ", 1))
}

/// Runs a node in 32 bits on a picture.
fn run(state: &str, node: &str, files: &dyn Loader, input: &Picture) -> Picture {
    Nodes::new(&on_source(node), &[("in", state)]).files(files).exact(&[input])
}

fn rgb(pixel: [f32; 4]) -> Rgb {
    [pixel[0], pixel[1], pixel[2]].map(f64::from)
}

/// Compares a node with its CPU reference, which maps colors, on a picture of every size.
fn compare(
    state: &str,
    node: &str,
    picture: fn([u32; 2]) -> Picture,
    tolerance: Tolerance,
    reference: impl Fn(Rgb) -> Rgb,
) {
    compare_with(state, node, &NoFiles, picture, tolerance, reference);
}

fn compare_with(
    state: &str,
    node: &str,
    files: &dyn Loader,
    picture: fn([u32; 2]) -> Picture,
    tolerance: Tolerance,
    reference: impl Fn(Rgb) -> Rgb,
) {
    for size in SIZES {
        let input = picture(size);
        let expected = image(&input).map_rgb(&reference);
        assert_close(&format!("{node} at {size:?}"), &run(state, node, files, &input), &expected, &tolerance);
    }
}

/// A result that a half float can hold.
pub(super) fn stored(rgb: Rgb) -> Rgb {
    rgb.map(|x| x.clamp(-LARGEST, LARGEST))
}

/// The same without negative light.
pub(super) fn stored_light(rgb: Rgb) -> Rgb {
    rgb.map(|x| x.clamp(0.0, LARGEST))
}

pub(super) struct OneFile(pub(super) Vec<u8>);

impl Loader for OneFile {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Ok(self.0.clone().into())
    }
}
