//! Bars, shafts of light, patterns, transforms and the removal of noise.

use crate::reference::image::{Image, center_uv};
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, image};

fn made(node: &str, state: &str, picture: &Picture) -> Picture {
    let text = format!("\"result\": {node}");
    Nodes::new(&text, &[("in", state)]).exact(&[picture])
}

/// Numbers of all sizes, above 1 as well.
fn mixed(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let spark = if (x * 7 + y * 3) % 23 == 0 { 37.3 } else { 0.0 };
        [x as f32 * 0.0137 + spark, (y as f32 * 0.7).sin().abs(), (x * y % 97) as f32 * 0.0101, 0.75]
    })
}

fn flat(width: u32, height: u32, light: f32) -> Picture {
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// Nodes whose parameters are neutral, and a state of their image.
const NEUTRAL: [(&str, &str); 22] = [
    ("Curves(source: \"in\")", "DisplayLinear"),
    ("Curves(source: \"in\", rgb_middle: (0.5, 0.7), amount: 0.0)", "DisplayLinear"),
    ("ChannelMixer(source: \"in\")", "Exposed"),
    ("SplitToning(source: \"in\", shadow_amount: 0.0, highlight_amount: 0.0)", "DisplayLinear"),
    ("HueCurves(source: \"in\")", "Exposed"),
    ("LensProfile(source: \"in\")", "Exposed"),
    ("Letterbox(source: \"in\", amount: 0.0)", "Encoded"),
    ("OrderedDither(source: \"in\", amount: 0.0)", "Encoded"),
    ("Palette(source: \"in\", amount: 0.0)", "Encoded"),
    ("Rcas(source: \"in\", sharpness: 0.0)", "Encoded"),
    ("Transform(source: \"in\")", "Exposed"),
    ("Denoise(source: \"in\", strength: 0.0)", "Exposed"),
    ("DirectionalBlur(source: \"in\", length: 0.0, angle: 30.0)", "Exposed"),
    ("GradientMap(source: \"in\", amount: 0.0)", "DisplayLinear"),
    ("Newsprint(source: \"in\", amount: 0.0)", "DisplayLinear"),
    ("Kuwahara(source: \"in\", radius: 0.0)", "Encoded"),
    ("LogWheels(source: \"in\", low: -1.0)", "Exposed"),
    ("RadialBlur(source: \"in\", zoom: 0.0, center: (0.2, 0.2))", "Exposed"),
    ("SaturationCurves(source: \"in\")", "Exposed"),
    ("VariableBlur(source: \"in\", mask: \"mask\", sigma: 0.0), \"mask\": GradientMask(source: \"in\")", "Exposed"),
    ("GodRays(source: \"in\", bright: \"in\", strength: 0.0)", "Exposed"),
    (
        "Mix(source: \"in\", other: \"other\", mask: \"mask\", amount: 0.0), \"mask\": LumaKey(source: \"in\"), \
      \"other\": Saturation(source: \"in\", amount: 0.0)",
        "Exposed",
    ),
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn neutral_parameters_change_no_bit() {
    for (width, height) in [(33, 17), (64, 36), (1, 1)] {
        let picture = mixed(width, height);
        for (node, state) in NEUTRAL {
            let found = made(node, state, &picture);
            assert!(found == picture, "{node} at {width}x{height}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bars_leave_a_picture_of_the_aspect() {
    for (width, height, aspect) in [(160, 80, 2.5), (160, 90, 2.39), (90, 160, 1.0), (51, 33, 4.0), (64, 36, 0.5)] {
        let node = format!("Letterbox(source: \"in\", aspect: {aspect:?}, color: (0.25, 0.0, 0.0))");
        let found = made(&node, "DisplayLinear", &flat(width, height, 1.0));
        let left: f64 = found.pixels.iter().map(|pixel| f64::from(pixel[1])).sum();
        let sides = [f64::from(width), f64::from(height)];
        let wanted =
            if sides[0] > aspect * sides[1] { aspect * sides[1] * sides[1] } else { sides[0] * sides[0] / aspect };
        assert!((left - wanted).abs() < 0.01, "{width}x{height} to {aspect}: {left} pixels instead of {wanted}");
        assert_eq!(found.at(width / 2, height / 2), [1.0; 4]);
        assert_eq!(found.at(0, 0), [0.25, 0.0, 0.0, 1.0]);
        assert_eq!(found.at(0, 0), found.at(width - 1, height - 1));
    }
    let own = mixed(64, 32);
    assert!(made("Letterbox(source: \"in\", aspect: 2.0)", "DisplayLinear", &own) == own, "it has the aspect");
}

/// A round spot of light, from uv around a place.
fn spot(uv: [f64; 2], center: [f64; 2], radius: f64) -> f64 {
    let distance = (uv[0] - center[0]).hypot(uv[1] - center[1]);
    4.0 * (-(distance / radius).powi(2)).exp()
}

fn spots(side: u32, center: [f64; 2], radius: f64) -> Picture {
    Picture::new(side, side, |x, y| {
        let light = spot(center_uv(x as usize, y as usize, side as usize, side as usize), center, radius) as f32;
        [light, light, light, 1.0]
    })
}

/// The shafts alone: on black.
fn rays(bright: &Picture, parameters: &str) -> Picture {
    let text = format!("\"result\": GodRays(source: \"dark\", bright: \"bright\", {parameters})");
    let dark = flat(bright.width, bright.height, 0.0);
    Nodes::new(&text, &[("dark", "Exposed"), ("bright", "Exposed")]).exact(&[&dark, bright])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn shafts_of_a_round_light_are_round_and_those_of_even_light_even() {
    let found = rays(&spots(64, [0.5, 0.5], 0.1), "light: (0.5, 0.5)");
    for y in 0..64 {
        for x in 0..64 {
            let own = found.at(x, y)[0];
            for other in [found.at(63 - x, y), found.at(x, 63 - y), found.at(y, x)] {
                assert!((own - other[0]).abs() < 1e-5, "at {x}, {y}: {own} and {}", other[0]);
            }
        }
    }
    // As far along a side as along a diagonal: 20 pixels.
    let (side, diagonal) = (found.at(52, 32)[0], found.at(46, 46)[0]);
    assert!(side > 0.05 && (side / diagonal - 1.0).abs() < 0.03, "{side} and {diagonal}");
    let even = rays(&flat(40, 24, 3.0), "light: (0.3, 0.6), strength: 2.0");
    let error = even.pixels.iter().map(|pixel| (pixel[1] - 6.0).abs()).fold(0.0, f32::max);
    assert!(error < 1e-4, "{error}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn shafts_are_the_sum_of_mitchell() {
    let (center, light) = ([0.35, 0.4], [0.4, 0.3]);
    let (length, falloff) = (0.7_f64, 0.3_f64);
    let found = rays(&spots(128, center, 0.12), "light: (0.4, 0.3), length: 0.7, falloff: 0.3");
    let wanted = Image::from_uv(128, 128, |uv| {
        let (mut sum, mut total) = (0.0, 0.0);
        for sample in 0..64 {
            let way = f64::from(sample) / 64.0;
            let (share, weight) = ((1.0 - length).powf(way), falloff.powf(way));
            let place = [0, 1].map(|i| light[i] + (uv[i] - light[i]) * share);
            sum += weight * spot(place, center, 0.12);
            total += weight;
        }
        [sum / total; 4]
    });
    let pairs = found.pixels.iter().zip(&wanted.pixels);
    let error = pairs.map(|(found, wanted)| (f64::from(found[0]) - wanted[0]).abs()).fold(0.0, f64::max);
    assert!(error < 0.04, "{error} of 4");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_beyond_the_border_is_dark() {
    let found = rays(&flat(64, 64, 1.0), "light: (0.5, -1.0), length: 0.9, falloff: 1.0");
    let column: Vec<f32> = (0..64).map(|y| found.at(32, y)[0]).collect();
    assert!(column.windows(2).all(|pair| pair[1] >= pair[0] - 1e-4), "{column:?}");
    assert!(column[0] < 0.1 && column[63] < 0.6, "{column:?}");
}

/// A light that is elsewhere makes no shafts from this place, and one at the place the same as before.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn only_what_is_near_the_light_shines() {
    let most = |center: [f64; 2], spread: &str| {
        let found = rays(&spots(64, center, 0.06), &format!("light: (0.3, 0.3), spread: {spread}"));
        found.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max)
    };
    let (near, far) = ([0.3, 0.3], [0.8, 0.7]);
    assert!(most(near, "0.25") > 0.8 * most(near, "0.0"), "{} of {}", most(near, "0.25"), most(near, "0.0"));
    assert!(most(far, "0.0") > 0.1, "{}", most(far, "0.0"));
    assert!(most(far, "0.25") < 0.02 * most(far, "0.0"), "{}", most(far, "0.25"));
}

/// The matrix of Bayer, as published.
const BAYER: [[u32; 8]; 8] = [
    [0, 32, 8, 40, 2, 34, 10, 42],
    [48, 16, 56, 24, 50, 18, 58, 26],
    [12, 44, 4, 36, 14, 46, 6, 38],
    [60, 28, 52, 20, 62, 30, 54, 22],
    [3, 35, 11, 43, 1, 33, 9, 41],
    [51, 19, 59, 27, 49, 17, 57, 25],
    [15, 47, 7, 39, 13, 45, 5, 37],
    [63, 31, 55, 23, 61, 29, 53, 21],
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dots_of_the_pattern_come_in_the_order_of_bayer() {
    for share in [0, 1, 20, 63, 64] {
        let found = made("OrderedDither(source: \"in\", levels: 2)", "Encoded", &flat(16, 8, share as f32 / 64.0));
        for (y, row) in BAYER.iter().enumerate() {
            for (x, rank) in row.iter().enumerate() {
                let wanted = if 63 - rank < share { 1.0 } else { 0.0 };
                assert_eq!(found.at(x as u32, y as u32)[0], wanted, "{share} of 64 at {x}, {y}");
                assert_eq!(found.at(x as u32 + 8, y as u32)[0], wanted, "the pattern does not repeat");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn levels_are_even_and_their_mean_is_that_of_the_image() {
    for (levels, light) in [(4, 0.41), (3, 0.123), (16, 0.777)] {
        let node = format!("OrderedDither(source: \"in\", levels: {levels}, dot: 2)");
        let found = made(&node, "Encoded", &flat(16, 16, light));
        let steps = (levels - 1) as f64;
        let values = found.pixels.iter().map(|pixel| f64::from(pixel[0]));
        assert!(values.clone().all(|value| (value * steps - (value * steps).round()).abs() < 1e-5), "{levels}");
        let mean = values.sum::<f64>() / 256.0;
        assert!((mean - f64::from(light)).abs() <= 0.5 / 64.0 / steps + 1e-6, "{levels}: {mean} instead of {light}");
        assert_eq!(found.at(0, 0), found.at(1, 1), "a dot has two pixels");
    }
    let banded = made("OrderedDither(source: \"in\", levels: 3, pattern: 0.0)", "Encoded", &flat(8, 8, 0.3));
    assert!(banded.pixels.iter().all(|pixel| pixel[0] == 0.5));
}

/// Six colors of no order, and their parameters.
const PALETTE: [[f64; 3]; 6] =
    [[0.1, 0.1, 0.2], [0.9, 0.8, 0.7], [0.2, 0.6, 0.3], [0.8, 0.3, 0.1], [0.3, 0.4, 0.9], [0.95, 0.9, 0.2]];

fn palette(parameters: &str) -> String {
    let colors = PALETTE.iter().enumerate().map(|(i, [r, g, b])| format!("color_{}: ({r:?}, {g:?}, {b:?})", i + 1));
    format!("Palette(source: \"in\", colors: 6, {}, {parameters})", colors.collect::<Vec<_>>().join(", "))
}

/// The squared distance of two colors by which a palette is searched.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    [0.299, 0.587, 0.114].iter().enumerate().map(|(i, weight)| weight * (a[i] - b[i]).powi(2)).sum()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dots_of_a_palette_have_the_mean_of_the_best_mixture() {
    for color in [[0.5, 0.5, 0.5], [0.25, 0.7, 0.5], [0.9, 0.1, 0.6], [0.0, 0.0, 0.0], [0.55, 0.45, 0.4]] {
        let picture = Picture::new(16, 8, |_, _| [color[0] as f32, color[1] as f32, color[2] as f32, 0.5]);
        let found = made(&palette("mixing: 0.0"), "Encoded", &picture);
        let mut mean = [0.0; 3];
        for pixel in &found.pixels {
            let own = [0, 1, 2].map(|i| f64::from(pixel[i]));
            assert!(PALETTE.iter().any(|known| apart(own, *known) < 1e-9), "{own:?} is no color of the palette");
            (0..3).for_each(|i| mean[i] += own[i] / 128.0);
        }
        // All mixtures of two colors in 64 parts.
        let mut best = f64::INFINITY;
        for (one, other) in PALETTE.iter().flat_map(|one| PALETTE.iter().map(move |other| (one, other))) {
            for part in (0..=64).map(|part| f64::from(part) / 64.0) {
                best = best.min(apart(color, [0, 1, 2].map(|i| one[i] + part * (other[i] - one[i]))));
            }
        }
        assert!(apart(color, mean).sqrt() < best.sqrt() + 0.008, "{color:?} becomes {mean:?}, not within {best}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn without_mixtures_each_pixel_has_the_nearest_color() {
    let picture = mixed(48, 32);
    let found = made(&palette("mixing: 1.0"), "Encoded", &picture);
    for (pixel, own) in found.pixels.iter().zip(&picture.pixels) {
        let own = [0, 1, 2].map(|i| f64::from(own[i]).clamp(0.0, 1.0));
        let nearest = PALETTE.iter().map(|known| apart(own, *known)).fold(f64::INFINITY, f64::min);
        let shown = apart(own, [0, 1, 2].map(|i| f64::from(pixel[i])));
        assert!(shown <= nearest + 1e-6, "{own:?} becomes {pixel:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_move_and_turn_by_whole_pixels() {
    let picture = mixed(32, 32);
    let turned = made("Transform(source: \"in\", rotation: 90.0)", "Exposed", &picture);
    let moved = made("Transform(source: \"in\", offset: (0.25, -0.125))", "Exposed", &picture);
    for (x, y) in [(3, 5), (20, 9), (30, 31), (16, 16)] {
        let is_close = |found: [f32; 4], wanted: [f32; 4]| (0..4).all(|c| (found[c] - wanted[c]).abs() < 1e-3);
        // Clockwise: what was at the left is at the top.
        assert!(is_close(turned.at(31 - y, x), picture.at(x, y)), "turned at {x}, {y}");
        let (to_x, to_y) = (x + 8, y.wrapping_sub(4));
        assert!(to_x > 31 || to_y > 31 || is_close(moved.at(to_x, to_y), picture.at(x, y)), "moved at {x}, {y}");
    }
    assert_eq!([moved.at(2, 3)[0], moved.at(20, 30)[0]], [0.0; 2], "no image is there");
    let repeated = made("Transform(source: \"in\", offset: (0.25, 0.0), repeat: true)", "Exposed", &picture);
    assert_eq!(repeated.at(2, 3), picture.at(0, 3));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_have_the_area_of_their_scale_and_crop() {
    let area = |parameters: &str| {
        let found = made(&format!("Transform(source: \"in\", {parameters})"), "Exposed", &flat(64, 48, 1.0));
        found.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / (64.0 * 48.0)
    };
    for (parameters, wanted) in [
        ("scale: 0.5", 0.25),
        ("scale: 0.25", 0.0625),
        ("scale: 0.5, rotation: 30.0", 0.25),
        ("crop: (0.25, 0.0, 0.25, 0.5)", 0.25),
        ("scale: 2.0, crop: (0.375, 0.375, 0.375, 0.375)", 0.25),
        ("offset: (0.25, -0.5)", 0.375),
        ("offset: (0.255, 0.0)", 0.745),
        ("crop: (0.5, 0.0, 0.495, 0.0)", 0.005),
    ] {
        let found = area(parameters);
        assert!((found - wanted).abs() < 1e-3, "{parameters}: {found} instead of {wanted}");
    }
    let cut = made("Transform(source: \"in\", crop: (0.25, 0.25, 0.25, 0.25))", "Exposed", &flat(64, 48, 1.0));
    assert_eq!([cut.at(15, 20)[3], cut.at(16, 20)[3], cut.at(47, 12)[3], cut.at(47, 11)[3]], [0.0, 1.0, 1.0, 0.0]);
    assert_eq!(area("crop: (0.6, 0.0, 0.6, 0.0)"), 0.0);
}

/// Five passes of 5x5 B-splines, as Dammertz et al. define them, without edges.
fn a_trous(source: &Image) -> Image {
    let weights = [1.0 / 16.0, 0.25, 0.375, 0.25, 1.0 / 16.0];
    (0..5).fold(source.clone(), |image, pass| {
        Image::new(source.width, source.height, |x, y| {
            let mut sum = [0.0; 4];
            for (j, down) in weights.iter().enumerate() {
                for (i, across) in weights.iter().enumerate() {
                    let place = [(x, i), (y, j)].map(|(at, k)| at as i64 + ((k as i64 - 2) << pass));
                    let read = image.texel(place[0], place[1]);
                    sum = std::array::from_fn(|c| sum[c] + across * down * read[c]);
                }
            }
            sum
        })
    })
}

/// Light with noise of this amplitude.
fn noisy(width: u32, height: u32, amplitude: f32, light: impl Fn(u32) -> f32) -> Picture {
    Picture::new(width, height, |x, y| {
        let bits = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 8;
        let value = light(x) * (1.0 + amplitude * (bits as f32 / 8_388_608.0 - 1.0));
        [value, value, value, 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn noise_that_is_small_is_blurred_by_the_wavelets() {
    let picture = noisy(48, 40, 0.002, |_| 0.5);
    let found = made("Denoise(source: \"in\", strength: 8.0)", "Exposed", &picture);
    let wanted = a_trous(&image(&picture));
    let pairs = found.pixels.iter().zip(&wanted.pixels);
    let error = pairs.map(|(found, wanted)| (f64::from(found[0]) - wanted[0]).abs()).fold(0.0, f64::max);
    assert!(error < 2e-6, "{error}");
}

/// The largest distance from the mean in columns of a picture, as a share of the mean.
fn spread(picture: &Picture, columns: std::ops::Range<u32>) -> f32 {
    let values: Vec<f32> = columns.flat_map(|x| (0..picture.height).map(move |y| picture.at(x, y)[0])).collect();
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    values.iter().map(|value| (value - mean).abs()).fold(0.0, f32::max) / mean
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn noise_goes_and_edges_stay() {
    let picture = noisy(64, 48, 0.1, |x| if x < 32 { 0.1 } else { 1.6 });
    let found = made("Denoise(source: \"in\", strength: 0.5)", "Exposed", &picture);
    for columns in [0..32, 32..64] {
        let (before, after) = (spread(&picture, columns.clone()), spread(&found, columns));
        assert!(before > 0.09 && after < 0.035, "{before} becomes {after}");
    }
    let even = flat(20, 20, 0.7);
    let same = made("Denoise(source: \"in\")", "Exposed", &even);
    assert!(same.pixels.iter().all(|pixel| (pixel[0] - 0.7).abs() < 1e-6));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn surfaces_at_other_depths_and_of_other_directions_do_not_mix() {
    let light = noisy(64, 16, 0.0, |x| if x < 32 { 0.5 } else { 0.6 });
    let depth = Picture::new(64, 16, |x, _| [if x < 32 { 2.0 } else { 9.0 }, 0.0, 0.0, 1.0]);
    let normal = Picture::new(64, 16, |x, _| if x < 32 { [0.0, 0.0, 1.0, 1.0] } else { [-1.0, 0.0, 0.0, 1.0] });
    let mixed = made("Denoise(source: \"in\", strength: 4.0)", "Exposed", &light);
    assert!((mixed.at(31, 8)[0] - 0.55).abs() < 0.01, "{:?}", mixed.at(31, 8));
    for (port, guide, most) in [("depth", &depth, 1e-4), ("normal", &normal, 0.03)] {
        let text = format!("\"result\": Denoise(source: \"in\", strength: 4.0, {port}: \"guide\")");
        let found = Nodes::new(&text, &[("in", "Exposed"), ("guide", "Data")]).exact(&[&light, guide]);
        assert!((found.at(31, 8)[0] - 0.5).abs() < most, "{port}: {:?}", found.at(31, 8));
        assert!((found.at(32, 8)[0] - 0.6).abs() < most, "{port}: {:?}", found.at(32, 8));
    }
}
