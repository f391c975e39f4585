//! Blurs along lines, around a point, and of a width that a mask gives.

use crate::reference::image::Image;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, image};

fn made(node: &str, picture: &Picture) -> Picture {
    let text = format!("\"result\": {node}");
    Nodes::new(&text, &[("in", "Exposed")]).exact(&[picture])
}

fn blurred(sigma: f64, picture: &Picture, mask: &Picture) -> Picture {
    let text = format!("\"result\": VariableBlur(source: \"in\", mask: \"mask\", sigma: {sigma:?})");
    Nodes::new(&text, &[("in", "Exposed"), ("mask", "Data")]).exact(&[picture, mask])
}

/// Numbers of all sizes, transparent and not.
fn mixed(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let spark = if (x * 7 + y * 3) % 23 == 0 { 37.3 } else { 0.0 };
        let alpha = if (x + 2 * y) % 5 == 0 { 0.25 } else { 1.0 };
        [x as f32 * 0.0137 + spark, (y as f32 * 0.7).sin().abs(), (x * y % 97) as f32 * 0.0101, alpha]
    })
}

/// A mask with slopes, an edge and a hole.
fn uneven(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let slope = x as f32 / width as f32;
        let share = if (3 * x + y) % 17 == 0 || y < height / 4 { 0.0 } else { slope };
        [share, 0.0, 0.0, 1.0]
    })
}

fn even(width: u32, height: u32, share: f32) -> Picture {
    Picture::new(width, height, |_, _| [share, 0.0, 0.0, 1.0])
}

fn sums(picture: &Picture) -> [f64; 4] {
    [0, 1, 2, 3].map(|c| picture.pixels.iter().map(|pixel| f64::from(pixel[c])).sum())
}

/// The largest difference of a channel, in parts of the largest number.
fn error(found: &Picture, wanted: &Image) -> f64 {
    let most = wanted.pixels.iter().flatten().fold(0.0_f64, |most, number| most.max(number.abs()));
    let pairs = found.pixels.iter().flatten().zip(wanted.pixels.iter().flatten());
    pairs.fold(0.0_f64, |worst, (found, wanted)| worst.max((f64::from(*found) - wanted).abs())) / most
}

/// What pairs of pixels have after nine exchanges. A pair is gone through once: what one gives the other gets.
fn diffused(source: &Image, shares: &[f64], sigma: f64) -> Image {
    let spline = [1.0 / 16.0, 0.25, 0.375, 0.25, 1.0 / 16.0];
    let (width, height) = (source.width as i64, source.height as i64);
    let mirrored = |at: i64, count: i64| {
        let within = at.rem_euclid(2 * count);
        if within < count { within } else { 2 * count - 1 - within }
    };
    let mut image = source.clone();
    for pass in 0..9 {
        let (step, square) = (1_i64 << pass, 4.0_f64.powi(pass));
        let rate = |index: usize| {
            let variance = (sigma * height as f64 * shares[index]).powi(2);
            ((variance - (square - 1.0) / 3.0) / square).clamp(0.0, 1.0)
        };
        let before = image.clone();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let own = (y * width + x) as usize;
            for (j, i) in (0..5).flat_map(|j| (0..5).map(move |i| (j, i))) {
                let place = [mirrored(x + step * (i - 2), width), mirrored(y + step * (j - 2), height)];
                let other = (place[1] * width + place[0]) as usize;
                let moved = 0.5 * spline[i as usize] * spline[j as usize] * rate(own).min(rate(other));
                for channel in 0..4 {
                    let given = moved * (before.pixels[own][channel] - before.pixels[other][channel]);
                    image.pixels[own][channel] -= given;
                    image.pixels[other][channel] += given;
                }
            }
        }
    }
    image
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_diffuses_where_the_mask_lets_it() {
    for ((width, height), sigma) in [((33, 17), 0.06), ((24, 61), 0.05), ((5, 70), 0.03), ((1, 1), 0.06)] {
        let (picture, mask) = (mixed(width, height), uneven(width, height));
        let shares: Vec<f64> = mask.pixels.iter().map(|pixel| f64::from(pixel[0])).collect();
        let wanted = diffused(&image(&picture), &shares, f64::from(sigma as f32));
        let found = blurred(sigma, &picture, &mask);
        let off = error(&found, &wanted);
        assert!(off < 1e-6, "{width}x{height}: {off}");
        assert!(width == 1 || error(&picture, &wanted) > 0.1, "nothing diffuses");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_width_of_a_mask_keeps_light_and_flat_pictures_and_the_bits_of_what_is_sharp() {
    let (picture, mask) = (mixed(61, 37), uneven(61, 37));
    let found = blurred(0.06, &picture, &mask);
    for (found, wanted) in sums(&found).iter().zip(sums(&picture)) {
        assert!((found / wanted - 1.0).abs() < 2e-6, "{found} of {wanted}");
    }
    for ((found, own), share) in found.pixels.iter().zip(&picture.pixels).zip(&mask.pixels) {
        assert!(share[0] > 0.0 || found == own, "a sharp pixel becomes {found:?} instead of {own:?}");
    }
    let most = |picture: &Picture| picture.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
    assert!(most(&found) <= most(&picture));
    let flat = Picture::new(61, 37, |_, _| [0.3, 60000.0, 1e-4, 0.7]);
    assert!(blurred(0.06, &flat, &mask) == flat);
    assert!(blurred(0.06, &picture, &even(61, 37, 0.0)) == picture);
    // What is sharp is not seen beside it: a lamp that no mask covers leaves its neighbors dark.
    let lamp = Picture::new(48, 48, |x, _| if x < 24 { [1000.0, 1000.0, 1000.0, 1.0] } else { [0.0, 0.0, 0.0, 1.0] });
    let beside = Picture::new(48, 48, |x, _| [if x < 24 { 0.0 } else { 1.0 }, 0.0, 0.0, 1.0]);
    assert!(blurred(0.06, &lamp, &beside) == lamp);
}

/// The variance of the light of a column of one bright pixel, and of its row.
fn variances(picture: &Picture, center: [u32; 2]) -> [f64; 2] {
    let total = sums(picture)[0];
    let places = (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| [x, y]));
    places.fold([0.0; 2], |sum, [x, y]| {
        let light = f64::from(picture.at(x, y)[0]) / total;
        let [across, down] = [0, 1].map(|axis| f64::from([x, y][axis]) - f64::from(center[axis]));
        [sum[0] + light * across * across, sum[1] + light * down * down]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_point_of_light_gets_the_standard_deviation_along_both_axes() {
    let side = 201;
    let point = Picture::new(side, side, |x, y| [if x == 100 && y == 100 { 100.0 } else { 0.0 }, 0.0, 0.0, 1.0]);
    for share in [0.05_f32, 0.1, 0.3, 0.5, 0.77, 1.0] {
        let found = blurred(0.06, &point, &even(side, side, share));
        let wanted = (0.06_f64 * f64::from(side) * f64::from(share)).powi(2);
        for found in variances(&found, [100, 100]) {
            assert!((found / wanted - 1.0).abs() < 1e-5, "a share of {share}: {found} instead of {wanted}");
        }
        // Along a diagonal as along a row: 10 and 7 + 7 pixels.
        let (row, diagonal) = (found.at(110, 100)[0], found.at(107, 107)[0]);
        assert!(share < 0.7 || (row / diagonal - 1.0).abs() < 0.02, "{row} and {diagonal}");
    }
}

/// Mirrored and turned pictures, and those that have moved, have results that are so, too.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn blurs_know_no_side_of_the_picture() {
    let mirrored = |picture: &Picture| Picture::new(37, 37, |x, y| picture.at(36 - x, y));
    let transposed = |picture: &Picture| Picture::new(37, 37, |x, y| picture.at(y, x));
    let close = |found: &Picture, wanted: &Picture| {
        let pairs = found.pixels.iter().flatten().zip(wanted.pixels.iter().flatten());
        pairs.fold(0.0_f32, |most, (a, b)| most.max((a - b).abs())) < 2e-4
    };
    let (picture, mask) = (mixed(37, 37), uneven(37, 37));
    let own = blurred(0.06, &picture, &mask);
    assert!(close(&blurred(0.06, &mirrored(&picture), &mirrored(&mask)), &mirrored(&own)));
    assert!(close(&blurred(0.06, &transposed(&picture), &transposed(&mask)), &transposed(&own)));
    for (node, mirror, transpose) in [
        (
            "DirectionalBlur(source: \"in\", length: 0.3, angle: 20.0)",
            "DirectionalBlur(source: \"in\", length: 0.3, angle: 160.0)",
            "DirectionalBlur(source: \"in\", length: 0.3, angle: 70.0)",
        ),
        (
            "RadialBlur(source: \"in\", center: (0.25, 0.4), zoom: 0.3, spin: 30.0)",
            "RadialBlur(source: \"in\", center: (0.75, 0.4), zoom: 0.3, spin: -30.0)",
            "RadialBlur(source: \"in\", center: (0.4, 0.25), zoom: 0.3, spin: -30.0)",
        ),
    ] {
        let own = made(node, &picture);
        assert!(close(&made(mirror, &mirrored(&picture)), &mirrored(&own)), "{node} mirrored");
        assert!(close(&made(transpose, &transposed(&picture)), &transposed(&own)), "{node} transposed");
    }
}

/// The mean of a thousand moments of an image that moves: `place` is where a pixel of the result was, in pixels, at a
/// moment from -0.5 to 0.5.
fn exposed(source: &Image, place: impl Fn([f64; 2], f64) -> [f64; 2]) -> Image {
    let size = [source.width as f64, source.height as f64];
    Image::from_uv(source.width, source.height, |uv| {
        let moments = (0..1000).map(|moment| (f64::from(moment) + 0.5) / 1000.0 - 0.5);
        let reads = moments.map(|moment| {
            let [x, y] = place([uv[0] * size[0], uv[1] * size[1]], moment);
            source.tap([x / size[0], y / size[1]])
        });
        reads.fold([0.0; 4], |sum, read| std::array::from_fn(|c| sum[c] + read[c] / 1000.0))
    })
}

/// Smooth light, which three reads in a row do not blur.
fn smooth(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let wave = |a: f32, b: f32| 0.5 + 0.5 * (a * x as f32 + b * y as f32).sin();
        [3.0 * wave(0.11, 0.05), wave(-0.07, 0.13), wave(0.0, 0.1), 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_long_exposure_is_the_mean_of_its_moments() {
    let picture = smooth(96, 64);
    let source = image(&picture);
    // Beyond the border, the mean of means differs from that of the border.
    let inner = |picture: &Picture, wanted: &Image| {
        let places = (20..44).flat_map(|y| (28..68).map(move |x| (x, y)));
        places.fold(0.0_f64, |most, (x, y)| {
            let (found, wanted) = (picture.at(x, y), wanted.texel(i64::from(x), i64::from(y)));
            (0..4).fold(most, |most, c| most.max((f64::from(found[c]) - wanted[c]).abs()))
        })
    };
    let (cos, sin) = 30.0_f64.to_radians().sin_cos();
    let line = exposed(&source, |[x, y], t| [x + 0.25 * 64.0 * t * sin, y + 0.25 * 64.0 * t * cos]);
    let found = made("DirectionalBlur(source: \"in\", length: 0.25, angle: 30.0)", &picture);
    assert!(inner(&found, &line) < 0.005, "{}", inner(&found, &line));
    assert!(inner(&picture, &line) > 0.1, "nothing is blurred");
    for (zoom, spin) in [(0.4, 0.0), (0.0, 40.0), (0.3, -25.0)] {
        let wanted = exposed(&source, |place, t| {
            let [x, y] = [place[0] - 0.5 * 96.0, place[1] - 0.6 * 64.0];
            let (sin, cos) = (t * f64::to_radians(spin)).sin_cos();
            let scale = (1.0_f64 + zoom).powf(t);
            [0.5 * 96.0 + scale * (cos * x - sin * y), 0.6 * 64.0 + scale * (sin * x + cos * y)]
        });
        let node = format!("RadialBlur(source: \"in\", center: (0.5, 0.6), zoom: {zoom:?}, spin: {spin:?})");
        let found = made(&node, &picture);
        assert!(inner(&found, &wanted) < 0.005, "{node}: {}", inner(&found, &wanted));
        assert!(inner(&picture, &wanted) > 0.05, "{node}: nothing is blurred");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_step_becomes_a_ramp_of_the_length_and_a_pixel_keeps_its_light() {
    let step = Picture::new(128, 40, |x, _| if x < 64 { [0.0, 0.0, 0.0, 1.0] } else { [8.0, 8.0, 8.0, 1.0] });
    let found = made("DirectionalBlur(source: \"in\", length: 1.0)", &step);
    for x in 0..128 {
        let wanted = (8.0 * (f64::from(x) + 0.5 - 64.0 + 20.0) / 40.0).clamp(0.0, 8.0);
        let off = (f64::from(found.at(x, 20)[0]) - wanted).abs();
        assert!(off < 0.01, "{off} at {x}");
    }
    let point = Picture::new(101, 101, |x, y| [if x == 60 && y == 45 { 1000.0 } else { 0.0 }, 0.0, 0.0, 1.0]);
    for (node, growth) in [
        ("DirectionalBlur(source: \"in\", length: 0.3, angle: 63.0)", 1.0),
        ("RadialBlur(source: \"in\", zoom: 0.0, spin: 50.0)", 1.0),
        // The mean of the areas of a picture that grows: of (1 + zoom)^(2 t).
        ("RadialBlur(source: \"in\", zoom: 1.0)", (2.0 - 0.5) / (2.0 * 2.0_f64.ln())),
    ] {
        let light = sums(&made(node, &point))[0] / 1000.0;
        assert!((light / growth - 1.0).abs() < 0.005, "{node}: {light} of {growth}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn flat_pictures_stay_so_and_one_pixel_stays() {
    let nodes = ["DirectionalBlur(source: \"in\", length: 2.0)", "RadialBlur(source: \"in\", zoom: 8.0, spin: 360.0)"];
    for (node, (width, height)) in nodes.iter().flat_map(|node| [(33, 17), (1, 1)].map(|size| (node, size))) {
        let flat = Picture::new(width, height, |_, _| [0.5, 65504.0, 0.0, 0.75]);
        let found = made(node, &flat);
        let pairs = found.pixels.iter().flatten().zip(flat.pixels.iter().flatten());
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() <= 1e-6 * b), "{node} at {width}x{height}");
    }
}
