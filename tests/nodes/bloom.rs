//! Kinds of bloom on the GPU, compared with their CPU references: what their tests share, Composite, and all together.

mod downsample;
mod extract;
mod fireflies;
mod gaussian;
mod laws;
mod lights;
mod upsample;

use crate::reference::bloom::{self, composite_add, composite_lerp, composite_screen};
use crate::reference::gaussian::blur_axis;
use crate::reference::image::{Image, rgb};
use crate::reference::resample::{Down, Firefly, Up, upsample};
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, image};
use crate::support::numbers::Numbers;

/// One texel, thinner than a filter, odd in both directions, a power of two, a frame with odd sides.
const SIZES: [[u32; 2]; 5] = [[1, 1], [2, 3], [5, 3], [64, 64], [161, 89]];

/// The brightest number that a half float holds.
const BRIGHTEST: f64 = 65504.0;

/// Tolerances relative to the brightest expected number within four pixels.
#[derive(Clone, Copy)]
pub(super) struct Precision {
    /// With 32 bits between the passes.
    pub(super) exact: f64,
    /// With half floats between the passes.
    half: f64,
    reason: &'static str,
}

impl Precision {
    pub(super) fn within(&self, relative: f64, absolute: f64) -> Tolerance {
        Tolerance { absolute, relative, of: Scale::Neighborhood, reason: self.reason }
    }
}

pub(super) const WHOLE: Precision = Precision { exact: 1e-5, half: 2e-3, reason: "texels are loaded: only rounding" };
pub(super) const SAMPLED: Precision =
    Precision { exact: 4e-3, half: 7e-3, reason: "a sampler may round its weights to 1/256" };

/// Scene light up to 8 with alpha in 0..1. Each of the `spikes` is the brightest number, in one channel of one pixel in
/// fifty.
pub(super) fn picture([width, height]: [u32; 2], spikes: bool) -> Picture {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    Picture::new(width, height, |x, y| {
        let light = 8.0 * numbers.next() * numbers.next();
        let mut pixel = [light * numbers.next(), light * numbers.next(), light * numbers.next(), numbers.next()];
        if spikes && numbers.next() < 0.02 {
            pixel[(x + y) as usize % 3] = BRIGHTEST;
        }
        pixel.map(|v| v as f32)
    })
}

/// The largest number of each channel within four pixels.
fn brightest_around(image: &Image) -> Image {
    let along = |image: &Image, [right, down]: [i64; 2]| {
        Image::new(image.width, image.height, |x, y| {
            let near = (-4..=4).map(|i| image.texel(x as i64 + i * right, y as i64 + i * down));
            near.fold([0.0; 4], |most, texel| [0, 1, 2, 3].map(|c| f64::max(most[c], texel[c])))
        })
    };
    along(&along(image, [1, 0]), [0, 1])
}

/// Fails unless all numbers lie between those of two images, up to rounding.
fn assert_between(what: &str, found: &Picture, [low, high]: [&Image; 2]) {
    for (index, found) in found.pixels.iter().enumerate() {
        let (low, high) = (low.pixels[index], high.pixels[index]);
        let is_inside = |c: usize| (low[c] * (1.0 - 1e-5)..=high[c] * (1.0 + 1e-5)).contains(&f64::from(found[c]));
        assert!((0..4).all(is_inside), "{what}: pixel {index}: {found:?} is not between {low:?} and {high:?}");
    }
}

fn bounded(image: Image) -> Image {
    image.map(|pixel| pixel.map(|v| v.min(BRIGHTEST)))
}

const SCENE: &[(&str, &str)] = &[("scene", "Color")];

/// A texture unit weighs two texels in steps of 1/256. Exact pipelines compute the weights: a tap is misplaced by less
/// than a hundredth of that.
const WEIGHT_STEPS: f64 = 100.0;

/// The error that misplaced taps cause: a GPU divides with an error of two and a half units in the last place, which
/// at a side of 641 texels moves a tap by 0.00005 texels.
fn misplaced(scene: &Picture) -> f64 {
    let brightest = scene.pixels.iter().flat_map(|pixel| &pixel[..3]).copied().fold(0.0, f32::max);
    if gpu().is_processor() { 0.0 } else { 5e-5 * f64::from(brightest) }
}

/// Compares `nodes` with the expected image, with 32 bits between passes and with 16.
fn check_on(nodes: &str, scene: &Picture, expected: &Image, precision: Precision) {
    check_each(nodes, &[scene], std::slice::from_ref(expected), precision);
}

/// The same for several pictures.
fn check_each(nodes: &str, scenes: &[&Picture], expected: &[Image], precision: Precision) {
    let graph = Nodes::new(nodes, SCENE).graph();
    let [exact, half] = [Run::new(&graph).exact(), Run::new(&graph)].map(|run| run.shown(scenes));
    for (at, scene) in scenes.iter().enumerate() {
        let (what, slack) = (format!("{}x{}: {nodes}", scene.width, scene.height), misplaced(scene));
        let of_exact = precision.within(precision.exact, slack);
        assert_close(&format!("exact {what}"), &exact[at], &expected[at], &of_exact);
        assert_close(&what, &half[at], &expected[at], &precision.within(precision.half, slack * WEIGHT_STEPS));
    }
}

/// A picture of every size, without and with spikes.
fn pictures() -> Vec<Picture> {
    SIZES.into_iter().flat_map(|size| [false, true].map(|spikes| picture(size, spikes))).collect()
}

/// Runs `nodes` at every size, without and with spikes.
fn check(nodes: &str, precision: Precision, reference: impl Fn(&Image) -> Image) {
    let scenes = pictures();
    let expected: Vec<Image> = scenes.iter().map(|scene| bounded(reference(&image(scene)))).collect();
    check_each(nodes, &scenes.iter().collect::<Vec<_>>(), &expected, precision);
}

fn scaled(weight: impl Fn([f64; 4]) -> f64) -> impl Fn(&Image) -> Image {
    move |image| {
        image.map(|pixel| {
            let weight = weight(pixel);
            [pixel[0] * weight, pixel[1] * weight, pixel[2] * weight, pixel[3]]
        })
    }
}

const FILTERS: [(&str, Down); 5] = [
    ("Box", Down::Box),
    ("Tap4", Down::FourTap),
    ("Tap9", Down::NineTap),
    ("Tap13", Down::ThirteenTap),
    ("Binomial", Down::Binomial),
];

/// As many levels as are asked for and the size allows.
pub(super) fn levels(image: &Image, asked: usize, filter: Down, firefly: Firefly) -> Vec<Image> {
    let most = image.width.max(image.height).ilog2() as usize;
    bloom::levels(image, asked.min(most).max(1), filter, firefly)
}

fn coarsest(image: &Image, asked: usize, filter: Down, firefly: Firefly) -> Image {
    levels(image, asked, filter, firefly).pop().expect("a pyramid has a level")
}

pub(super) fn blurred(half: &[f64]) -> impl Fn(&Image) -> Image {
    move |image| blur_axis(&blur_axis(image, half, [1, 0]), half, [0, 1])
}

/// Half of the nine taps that Caracal uses.
pub(super) fn caracal_taps() -> Vec<f64> {
    printed(&[0.227027, 0.194596, 0.121621, 0.054054, 0.016216])
}

/// Half a kernel as a document prints it, made to sum to 1.
fn printed(half: &[f64]) -> Vec<f64> {
    let total = half[0] + 2.0 * half[1..].iter().sum::<f64>();
    half.iter().map(|weight| weight / total).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn composite_adds_and_mixes_light_as_its_cpu_reference() {
    let scenes = pictures();
    let halves = |scene: &Picture, spikes| picture([scene.width.div_ceil(2), scene.height.div_ceil(2)], spikes);
    let lights: Vec<Picture> = scenes.iter().enumerate().map(|(at, scene)| halves(scene, at % 2 == 1)).collect();
    let inputs: Vec<[(&str, &Picture); 2]> =
        scenes.iter().zip(&lights).map(|(scene, light)| [("scene", scene), ("light", light)]).collect();
    let inputs: Vec<&[(&str, &Picture)]> = inputs.iter().map(<[_; 2]>::as_slice).collect();
    for (filter, up) in [("Tent", Up::Tent), ("Bilinear", Up::Bilinear)] {
        let mut enlarged = Vec::new();
        for (scene, light) in scenes.iter().zip(&lights) {
            let (light, size) = (image(light), [scene.width as usize, scene.height as usize]);
            let is_equal = [light.width, light.height] == size;
            let open = if filter == "Tent" { light.with_open_beyond() } else { light.clone() };
            let [mean, added] =
                [&light, &open].map(|light| if is_equal { light.clone() } else { upsample(light, size, up, 1.0) });
            enlarged.push((brightest_around(&mean), mean, added));
        }
        for (blend, reference) in
            [("Add", composite_add as fn(_, _, _) -> _), ("Mix", composite_lerp), ("Screen", composite_screen)]
        {
            let nodes = format!(
                r#""result": Composite(base: "scene", bloom: "light",
                    blend: {blend}, filter: {filter}, strength: 0.3)"#
            );
            let graph = Nodes::new(&nodes, &[("scene", "Color"), ("light", "Color")]).graph();
            for (at, found) in Run::new(&graph).exact().first_frames(&inputs).iter().enumerate() {
                let (scene, (around, mean, added)) = (&scenes[at], &enlarged[at]);
                let large = if blend == "Mix" { mean } else { added };
                // All three grow with the light, whose filter may err by a share of the brightest light around.
                let with = |share: f64| {
                    Image::new(large.width, large.height, |x, y| {
                        let [light, around] = [large, around].map(|image| image.texel(x as i64, y as i64));
                        let light = [0, 1, 2, 3].map(|i| (light[i] + share * around[i]).max(0.0));
                        let base = scene.at(x as u32, y as u32).map(f64::from);
                        let [r, g, b] = reference(rgb(base), rgb(light), 0.3);
                        let alpha = if blend == "Mix" { 0.7 * base[3] + 0.3 * light[3] } else { base[3] };
                        [r, g, b, alpha].map(|v| v.min(BRIGHTEST))
                    })
                };
                let [low, high] = [with(-SAMPLED.exact), with(SAMPLED.exact)];
                assert_between(&format!("{}x{}: {nodes}", scene.width, scene.height), &found[0], [&low, &high]);
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_brightest_lights_stay_within_half_range() {
    let scene = Picture::new(9, 7, |_, _| [BRIGHTEST as f32, BRIGHTEST as f32, 0.0, 1.0]);
    let nodes = r#"
        "bright": Extract(source: "scene", intensity: 64.0),
        "mips": Downsample(source: "bright", levels: 3),
        "bloom": Upsample(source: "mips", blend: Add, normalize: false),
        "result": Composite(base: "scene", bloom: "bloom", strength: 8.0)"#;
    check_on(nodes, &scene, &image(&scene), WHOLE);
}
