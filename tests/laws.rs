//! Laws of pictures that all built-in pipelines keep: mirrored, transposed and moved pictures, lights in all phases of
//! the pixels, at borders and in corners, first frames and cuts. Three pipelines run every day; all with
//! `AFTERIMAGE_SWEEPS=all`.

use std::array::from_fn;

use afterimage_graph::check::Graph;
use afterimage_lab::metrics::srgb_decode;

use crate::pipelines::files;
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::numbers::Numbers;
use crate::support::sequence::Sequence;
use crate::support::sweep;

const SIDE: u32 = 128;
/// Pixels around a lamp that show the lamp itself.
const NEAR: f64 = 12.0;
/// Of the glow of a lamp that has none worth the name, in pixels of white.
const NO_GLOW: f64 = 0.02;
const GRAY: f32 = 0.18;
const LAMP: f32 = 500.0 * GRAY;

/// A built-in pipeline without noise, which has no symmetry, and without what darkens corners.
struct Subject {
    name: String,
    graph: Graph,
}

/// Three of the pipelines, or all, but for those that break a law on purpose.
fn subjects(without: &[&str]) -> Vec<Subject> {
    let of = |name: String| {
        let mut graph = built_in(&name, None);
        for node in &mut graph.nodes {
            node.off |= ["Dither", "FilmGrain", "Vignette"].contains(&node.kind().name());
        }
        Subject { name: name.trim_end_matches(".ron").to_owned(), graph }
    };
    let names = files().into_iter().filter(|name| !without.contains(&name.trim_end_matches(".ron")));
    sweep::some(names.collect::<Vec<_>>(), 3).into_iter().map(of).collect()
}

impl Subject {
    fn input<'p>(&self, picture: &'p Picture) -> [(&str, &'p Picture); 1] {
        let input = self.graph.inputs.iter().find(|input| !input.optional).expect("it needs a picture");
        [(input.name.as_str(), picture)]
    }

    /// The first output of the first frame with each picture.
    fn shown(&self, pictures: &[Picture]) -> Vec<Picture> {
        let run = Run::new(&self.graph).exact();
        let inputs: Vec<_> = pictures.iter().map(|picture| self.input(picture)).collect();
        let inputs: Vec<&[(&str, &Picture)]> = inputs.iter().map(<[_; 1]>::as_slice).collect();
        run.first_frames(&inputs).into_iter().map(|mut outputs| outputs.swap_remove(0)).collect()
    }
}

/// A gradient with patches of other colors and brightnesses; alpha is 1 in those that are bright, as a mask of lights.
fn scene(seed: u64) -> Picture {
    let mut numbers = Numbers(seed);
    let patches: [[f32; 8]; 24] = from_fn(|_| from_fn(|_| numbers.next() as f32));
    Picture::new(SIDE, SIDE, |x, y| {
        let [x, y] = [x, y].map(|at| (at as f32 + 0.5) / SIDE as f32);
        let mut pixel = [0.1 + 0.3 * y, 0.1 + 0.2 * x, 0.3 - 0.2 * y, 0.0];
        for [left, top, width, height, bright, r, g, b] in patches {
            let is_inside = (x - left).abs() < 0.02 + 0.1 * width && (y - top).abs() < 0.02 + 0.1 * height;
            if is_inside {
                let light = (12.0 * bright - 6.0).exp2();
                pixel = [light * (0.3 + r), light * (0.3 + g), light * (0.3 + b), f32::from(light > 2.0)];
            }
        }
        pixel
    })
}

/// A square lamp in front of gray, with its upper left pixel at a place.
fn lamp(size: u32, [left, top]: [u32; 2]) -> Picture {
    Picture::new(SIDE, SIDE, |x, y| {
        let is_lamp = (left..left + size).contains(&x) && (top..top + size).contains(&y);
        let light = if is_lamp { LAMP } else { GRAY };
        [light, light, light, f32::from(is_lamp)]
    })
}

fn mirror(picture: &Picture) -> Picture {
    Picture::new(picture.width, picture.height, |x, y| picture.at(picture.width - 1 - x, y))
}

fn transpose(picture: &Picture) -> Picture {
    Picture::new(picture.height, picture.width, |x, y| picture.at(y, x))
}

/// The codes of 8 bits by which this share of all values differs at most.
fn codes_off(a: &Picture, b: &Picture, share: f64) -> f32 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let channels = |picture: &Picture| picture.pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<_>>();
    let mut off: Vec<f32> = std::iter::zip(channels(a), channels(b)).map(|(a, b)| 255.0 * (a - b).abs()).collect();
    off.sort_by(f32::total_cmp);
    off[((off.len() - 1) as f64 * share) as usize]
}

/// The light of pixels that a lamp adds, where it is not near, summed over an area.
fn glow(lit: &Picture, dark: &Picture, is_part: impl Fn(f64, f64) -> bool) -> f64 {
    let light = |[r, g, b, _]: [f32; 4]| {
        let [r, g, b] = [r, g, b].map(|code| srgb_decode(f64::from(code)));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let scale = f64::from(lit.width) / f64::from(SIDE);
    let places = (0..lit.height).flat_map(|y| (0..lit.width).map(move |x| (x, y)));
    let is_part = |x: u32, y: u32| is_part((f64::from(x) + 0.5) / scale, (f64::from(y) + 0.5) / scale);
    places.filter(|(x, y)| is_part(*x, *y)).map(|(x, y)| light(lit.at(x, y)) - light(dark.at(x, y))).sum::<f64>()
        / (scale * scale)
}

/// The light shafts of `matinee.ron` come from a place, and its bars are above and below.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn mirrored_and_transposed_pictures_are_mirrored_and_transposed() {
    for subject in subjects(&["matinee"]) {
        let own = scene(1);
        let shown = subject.shown(&[own.clone(), mirror(&own), transpose(&own)]);
        for (way, turned) in [("mirrored", mirror(&shown[1])), ("transposed", transpose(&shown[2]))] {
            // The grid of `tsushima.ron` is twice as wide as it is high, and Smaa takes one diagonal before the other.
            let off = codes_off(&shown[0], &turned, 0.99);
            assert!(off <= 1.0, "{} {way} is off by {off} codes", subject.name);
        }
    }
}

/// The light shafts of `matinee.ron` depend on the place of their light.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_picture_that_moves_by_pixels_stays_the_same() {
    for subject in subjects(&["matinee"]) {
        let whole = scene(2);
        // A patch moves in front of gray, so that nothing comes into view.
        let at = |left: u32| {
            Picture::new(SIDE, SIDE, |x, y| match (x.checked_sub(left), y.checked_sub(40)) {
                (Some(x @ ..48), Some(y @ ..48)) => whole.at(x + 40, y + 40),
                _ => [GRAY, GRAY, GRAY, 0.0],
            })
        };
        let shown = subject.shown(&[at(40), at(41), at(42), at(43)]);
        for (pixels, moved) in (1..).zip(&shown[1..]) {
            let part = |picture: &Picture, from: u32| {
                let scale = picture.width / SIDE;
                let width = picture.width - 8 * scale;
                Picture::new(width, picture.height, |x, y| picture.at(x + from * scale, y))
            };
            let off = codes_off(&part(&shown[0], 0), &part(moved, pixels), 0.99);
            assert!(off <= 3.0, "{}, moved by {pixels}, is off by {off} codes", subject.name);
        }
    }
}

/// In `glare.ron` and `course.ron`, a curve comes before the blur, and a part of a bright pixel counts as a whole one.
/// The shafts of `matinee.ron` depend on their place.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_glow_is_steady_in_all_phases_of_its_light() {
    for subject in subjects(&["course", "glare", "matinee"]) {
        for size in [1, 2, 3, 8] {
            let places: [[u32; 2]; 16] = from_fn(|phase| [48 + phase as u32, 52]);
            let pictures = places.into_iter().map(|place| lamp(size, place)).chain([lamp(0, [0; 2])]);
            let shown = subject.shown(&pictures.collect::<Vec<_>>());
            let glows = places.map(|[left, top]| {
                let middle = [left, top].map(|at| f64::from(at) + f64::from(size) / 2.0);
                let is_far = |x: f64, y: f64| (x - middle[0]).hypot(y - middle[1]) > NEAR;
                glow(&shown[(left - 48) as usize], &shown[16], is_far)
            });
            let mean = glows.iter().sum::<f64>() / 16.0;
            let swing = glows.iter().map(|glow| (glow - mean).abs()).fold(0.0, f64::max);
            let is_steady = mean.abs() < NO_GLOW || swing <= 0.025 * mean.abs();
            assert!(is_steady, "{}: the glow of {size} pixels is {mean} and swings by {swing}", subject.name);
        }
    }
}

/// Beyond a border lies half of the nearest light, which is a little more than there would be, in a corner twice.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_glow_is_as_strong_at_borders_and_nearly_so_in_corners() {
    for subject in subjects(&["matinee"]) {
        let places = [[60, 60], [0, 60], [0, 0]];
        let pictures = places.into_iter().map(|place| lamp(8, place)).chain([lamp(0, [0; 2])]);
        let shown = subject.shown(&pictures.collect::<Vec<_>>());
        let [middle, border, corner] = from_fn(|index| {
            let [left, top] = places[index].map(f64::from);
            let is_beside = |x: f64, y: f64| (left + 16.0..left + 32.0).contains(&x) && (top..top + 8.0).contains(&y);
            glow(&shown[index], &shown[3], is_beside)
        });
        if middle.abs() >= NO_GLOW {
            let [border, corner] = [border, corner].map(|glow| (glow / middle - 1.0).abs());
            assert!(border <= 0.06, "{}: the glow at a border is off by a share of {border}", subject.name);
            assert!(corner <= 0.35, "{}: the glow in a corner is off by a share of {corner}", subject.name);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_first_frame_is_that_of_a_still_and_a_cut_forgets() {
    for subject in subjects(&[]) {
        let run = Run::new(&subject.graph);
        let (still, other) = (lamp(1, [64, 40]), scene(3));
        let mut sequence = Sequence::new(&run);
        let mut frame = |picture: &Picture, is_first: bool| {
            sequence.frame(&subject.input(picture), if is_first { 0.0 } else { 1.0 / 24.0 }, is_first);
            sequence.outputs().swap_remove(0)
        };
        let first = frame(&still, true);
        let later = (0..4).map(|_| frame(&still, false)).last().expect("frames");
        frame(&other, true);
        frame(&other, false);
        let cut = frame(&still, true);
        for (which, shown) in [("fifth", later), ("first after a cut", cut)] {
            let off = codes_off(&first, &shown, 1.0);
            assert!(off <= 0.1, "{}: the {which} frame is off by {off} codes", subject.name);
        }
    }
}
