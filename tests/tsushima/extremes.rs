//! Numbers and sizes at their limits: what comes out is finite, no square is black, nothing flashes, and the frame
//! after is as if nothing had been.

use crate::support::gpu::{Picture, Run, built_in};
use crate::support::sequence::Sequence;

const STEP: f32 = 1.0 / 24.0;

fn plain(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let light = 0.1 + 0.8 * (x as f32 + 0.5) / width as f32 + 0.2 * (y as f32 + 0.5) / height as f32;
        [light, 0.8 * light, 0.6 * light, 1.0]
    })
}

/// The plain picture with some pixels replaced.
fn spoilt(width: u32, height: u32, pixel: impl Fn(u32, u32) -> Option<f32>) -> Picture {
    let clean = plain(width, height);
    Picture::new(width, height, |x, y| pixel(x, y).map_or(clean.at(x, y), |light| [light; 4]))
}

fn filled(width: u32, height: u32, light: f32) -> Picture {
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// The display pictures of a plain frame, a frame that may be extreme, and the plain one again.
fn around(middle: &Picture) -> [Picture; 3] {
    let graph = built_in(super::PIPELINE, None);
    let clean = plain(middle.width, middle.height);
    let run = Run::new(&graph);
    let mut frames = Sequence::new(&run);
    [(&clean, true), (middle, false), (&clean, false)].map(|(picture, reset)| {
        frames.frame(&[("scene", picture)], STEP, reset);
        frames.output("display")
    })
}

fn assert_fit_to_show(what: &str, picture: &Picture) {
    let good = |pixel: &[f32; 4]| pixel[..3].iter().all(|x| (0.0..=1.0).contains(x));
    assert!(picture.pixels.iter().all(good), "{what}: not all numbers lie in 0 to 1");
}

fn mean(picture: &Picture) -> f32 {
    let sum: f32 = picture.pixels.iter().map(|[r, g, b, _]| r + g + b).sum();
    sum / (3 * picture.pixels.len()) as f32
}

/// How much a picture is at most darker than another, and at most brighter.
fn change(before: &Picture, after: &Picture) -> [f32; 2] {
    let pairs = before.pixels.iter().zip(&after.pixels);
    let steps = pairs.flat_map(|(a, b)| (0..3).map(move |channel| b[channel] - a[channel]));
    steps.fold([0.0, 0.0], |[down, up], step| [down.max(-step), up.max(step)])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_black_frame_is_black_and_leaves_the_exposure_alone() {
    let [before, black, after] = around(&filled(96, 54, 0.0));
    assert_fit_to_show("black", &black);
    assert!(mean(&black) < 0.002, "{}", mean(&black));
    assert_eq!(super::bits(&[before]), super::bits(&[after]), "nothing was metered, so nothing moved");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_black_first_frame_does_not_affect_the_next() {
    let graph = built_in(super::PIPELINE, None);
    let (black, clean) = (filled(96, 54, 0.0), plain(96, 54));
    let run = Run::new(&graph);
    let mut frames = Sequence::new(&run);
    for (picture, reset) in [(&black, true), (&clean, false)] {
        frames.frame(&[("scene", picture)], STEP, reset);
    }
    let seen = frames.output("display");
    // A test has one sequence at a time.
    drop(frames);
    let [first, ..] = around(&clean);
    assert_eq!(super::bits(&[seen]), super::bits(&[first]), "the first light that is metered is a beginning");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_white_frame_is_white_and_the_next_is_no_flash() {
    for light in [65504.0, f32::INFINITY, f32::MAX] {
        let [before, white, after] = around(&filled(96, 54, light));
        assert_fit_to_show("white", &white);
        let middle = white.at(48, 27);
        assert!(middle[..3].iter().all(|x| *x > 0.99), "{light}: {middle:?}");
        // The eye has begun to get used to it, as it should: the next frame is darker, by less than one such step can
        // be.
        let [_, up] = change(&before, &after);
        assert!(up <= 1.0 / 255.0, "{light}: brighter by {up}");
        assert!(mean(&after) > 0.3 * mean(&before), "{light}: {} to {}", mean(&before), mean(&after));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_pixel_as_bright_as_can_be_glows_and_does_no_more() {
    // An infinity is light if it is not alone.
    for (light, width) in [(65504.0, 1), (f32::INFINITY, 2)] {
        let is_bright = |x: u32, y: u32| (31..31 + width).contains(&x) && y == 20;
        let [before, bright, after] = around(&spoilt(96, 54, |x, y| is_bright(x, y).then_some(light)));
        assert_fit_to_show("one bright pixel", &bright);
        let [down, _] = change(&before, &bright);
        assert!(down < 0.05, "nothing around it turns black: {down}");
        assert!(bright.at(31, 20)[..3].iter().all(|x| *x > 0.95), "{:?}", bright.at(31, 20));
        assert!(bright.at(92, 50)[0] - before.at(92, 50)[0] < 0.1, "far away nothing flashes");
        assert!(change(&before, &after).iter().all(|x| *x <= 1.5 / 255.0), "{:?}", change(&before, &after));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pixels_that_are_no_numbers_stay_where_they_are() {
    for light in [f32::NAN, f32::NEG_INFINITY, -1e30] {
        let picture = spoilt(96, 54, |x, y| ((x, y) == (31, 20) || (x, y) == (70, 33)).then_some(light));
        let [before, spoilt, after] = around(&picture);
        assert_fit_to_show("not a number", &spoilt);
        for (index, (clean, found)) in before.pixels.iter().zip(&spoilt.pixels).enumerate() {
            let (x, y) = (index as u32 % 96, index as u32 / 96);
            let is_itself = (x, y) == (31, 20) || (x, y) == (70, 33);
            let off = (0..3).map(|c| (clean[c] - found[c]).abs()).fold(0.0, f32::max);
            assert!(is_itself || off < 0.03, "{light} spread to ({x}, {y}): {clean:?} {found:?}");
        }
        assert!(change(&before, &after).iter().all(|x| *x <= 1.5 / 255.0), "{:?}", change(&before, &after));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_of_nothing_but_nan_is_a_black_frame() {
    let [before, nothing, after] = around(&filled(96, 54, f32::NAN));
    assert_fit_to_show("all NaN", &nothing);
    assert!(mean(&nothing) < 0.002);
    assert_eq!(super::bits(&[before]), super::bits(&[after]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_pixel_and_one_line_are_pictures_too() {
    for (width, height) in [(1, 1), (1, 40), (3, 2), (16384, 2)] {
        let [first, again, after] = around(&plain(width, height));
        assert_fit_to_show("small", &first);
        assert!((0.05..0.95).contains(&mean(&first)), "{width}x{height}: {}", mean(&first));
        assert_eq!(super::bits(std::slice::from_ref(&first)), super::bits(&[again]), "{width}x{height}");
        assert_eq!(super::bits(&[first]), super::bits(&[after]), "{width}x{height}");
        let [_, hot, _] = around(&spoilt(width, height, |x, _| (x == width / 2).then_some(f32::NAN)));
        assert_fit_to_show("small and spoilt", &hot);
    }
}
