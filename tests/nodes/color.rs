//! The tone and colour kinds on the GPU against their f64 twins.

mod baked;
mod curves;
mod grade;
mod lut;
mod noise;
mod transfer;

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Graph, Loader, NoFiles, check};
use afterimage_graph::document::parse;

use crate::reference::math::{Rgb, largest};
use crate::support::gpu::{Picture, Run, registry};
use crate::support::numbers::Numbers;

/// One texel, fewer texels than a workgroup, odd sides that no workgroup divides.
const SIZES: [[u32; 2]; 3] = [[1, 1], [2, 3], [61, 37]];

/// The largest half float.
const LARGEST: f64 = 65504.0;

/// A share of the largest channel, and a number below which differences do not count. The classes are those of the test vectors.
#[derive(Clone, Copy)]
struct Tolerance {
    absolute: f64,
    relative: f64,
}

/// Sums and products.
const ARITHMETIC: Tolerance = Tolerance { absolute: 1e-6, relative: 2e-6 };
/// Powers, exponentials and logarithms.
const TRANSCENDENTAL: Tolerance = Tolerance { absolute: 2e-6, relative: 1e-5 };

/// Colours that curves are known to stumble over.
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

/// The special colours, then light from 2^-14 to the largest half float in every saturation. Alpha is any number.
fn light([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let mut random = move || (30.0 * numbers.next() - 14.0).exp2();
    picture([width, height], move |index| SPECIAL.get(index).copied().unwrap_or_else(|| [random(), random(), random()]))
}

/// Colours from 0 to 1, black and white among them.
fn unit([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    let corner = |index: usize| [0, 1, 2].map(|channel| f64::from((index >> channel & 1) as u8));
    let mut random = move || numbers.next().powi(2);
    picture([width, height], move |index| if index < 8 { corner(index) } else { [random(), random(), random()] })
}

fn picture([width, height]: [u32; 2], mut color: impl FnMut(usize) -> Rgb) -> Picture {
    Picture::new(width, height, |x, y| {
        let [r, g, b] = color((x + y * width) as usize).map(|v| v.min(LARGEST) as f32);
        [r, g, b, (x % 5) as f32 * 0.3]
    })
}

/// A pipeline of one node whose `source` is an image in the given state.
fn pipeline(state: &str, node: &str) -> String {
    let node = node.replacen('(', "(source: \"in\", ", 1);
    format!("Pipeline(inputs: {{ \"in\": {state} }}, nodes: {{ \"out\": {node} }}, outputs: {{ \"out\": \"out\" }})")
}

fn graph_with(text: &str, loader: &dyn Loader) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { loader, ..CheckOptions::default() };
    check(&document, &registry(), &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// Runs a node in 32 bits on a picture.
fn run(state: &str, node: &str, loader: &dyn Loader, input: &Picture) -> Picture {
    let graph = graph_with(&pipeline(state, node), loader);
    Run::new(&graph).exact().frame(&[("in", input)]).remove(0)
}

fn rgb(pixel: [f32; 4]) -> Rgb {
    [pixel[0], pixel[1], pixel[2]].map(f64::from)
}

/// What is wrong with a result; empty when nothing is. Alpha must have passed through.
fn mistakes(input: &Picture, output: &Picture, tolerance: Tolerance, twin: &dyn Fn(Rgb) -> Rgb) -> Vec<String> {
    assert_eq!((input.width, input.height), (output.width, output.height));
    let check = |(&from, &to): (&[f32; 4], &[f32; 4])| {
        let (expected, found) = (twin(rgb(from)), rgb(to));
        let allowed = tolerance.absolute + tolerance.relative * largest(expected.map(f64::abs));
        let close = (0..3).all(|channel| (found[channel] - expected[channel]).abs() <= allowed);
        (!close || from[3] != to[3]).then(|| format!("{from:?}: {to:?} instead of {expected:?}"))
    };
    input.pixels.iter().zip(&output.pixels).filter_map(check).collect()
}

/// Holds a node against its twin, on a picture of every size.
fn compare(state: &str, node: &str, picture: fn([u32; 2]) -> Picture, tolerance: Tolerance, twin: impl Fn(Rgb) -> Rgb) {
    compare_with(state, node, &NoFiles, picture, tolerance, twin);
}

fn compare_with(
    state: &str,
    node: &str,
    loader: &dyn Loader,
    picture: fn([u32; 2]) -> Picture,
    tolerance: Tolerance,
    twin: impl Fn(Rgb) -> Rgb,
) {
    for size in SIZES {
        let input = picture(size);
        let mistakes = mistakes(&input, &run(state, node, loader, &input), tolerance, &twin);
        let shown = mistakes.iter().take(8).map(String::as_str).collect::<Vec<_>>().join("\n");
        assert!(mistakes.is_empty(), "{node} at {size:?}: {} pixels are off\n{shown}", mistakes.len());
    }
}

/// A result that a half float can hold.
fn stored(rgb: Rgb) -> Rgb {
    rgb.map(|x| x.clamp(-LARGEST, LARGEST))
}

/// The same without negative light.
fn stored_light(rgb: Rgb) -> Rgb {
    rgb.map(|x| x.clamp(0.0, LARGEST))
}

/// One file in memory.
struct OneFile(Vec<u8>);

impl Loader for OneFile {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Ok(self.0.clone().into())
    }
}
