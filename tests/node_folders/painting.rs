//! Strokes of paint and dots of ink.

use crate::reference::image::Image;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, image};

fn made(node: &str, picture: &Picture) -> Picture {
    let text = format!("\"result\": {node}");
    Nodes::new(&text, &[("in", "Encoded")]).exact(&[picture])
}

/// Slanted waves of all widths, an edge, and noise.
fn drawn(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let bits = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 8;
        let noise = 0.06 * (bits as f32 / 8_388_608.0 - 1.0);
        let (u, v) = (x as f32, y as f32);
        let edge = if 2 * x > width / 2 + y % 97 { 0.3 } else { 0.0 };
        let wave = |a: f32, b: f32, c: f32| (0.35 + 0.25 * (a * u + b * v + c * u * v).sin() + edge + noise).max(0.0);
        [wave(0.3, 0.1, 1e-3), wave(-0.1, 0.21, 0.0), wave(0.05, -0.13, 2e-3), 1.0 - 0.5 * noise.abs()]
    })
}

/// A Gaussian of two pixels, cut at three deviations.
fn softened(image: &Image, axis: [i64; 2]) -> Image {
    let weights: Vec<f64> = (-6..=6).map(|i| (-f64::from(i * i) / 8.0).exp()).collect();
    let total: f64 = weights.iter().sum();
    Image::new(image.width, image.height, |x, y| {
        weights.iter().zip(-6..).fold([0.0; 4], |sum, (weight, i)| {
            let read = image.texel(x as i64 + i * axis[0], y as i64 + i * axis[1]);
            std::array::from_fn(|c| sum[c] + weight / total * read[c])
        })
    })
}

/// The structure tensor as the matrix [[x, y], [y, z]], smoothed.
fn tensors(source: &Image) -> Image {
    let raw = Image::new(source.width, source.height, |x, y| {
        let read = |i: i64, j: i64| source.texel(x as i64 + i, y as i64 + j);
        let slope = |c: usize, flip: bool| {
            let at = |along: i64, beside: i64| if flip { read(beside, along)[c] } else { read(along, beside)[c] };
            [-1, 0, 1].map(|beside| (at(1, beside) - at(-1, beside)) * if beside == 0 { 0.5 } else { 0.25 })
        };
        (0..3).fold([0.0; 4], |sum, c| {
            let (across, down): (f64, f64) = (slope(c, false).iter().sum(), slope(c, true).iter().sum());
            [sum[0] + across * across, sum[1] + across * down, sum[2] + down * down, 1.0]
        })
    });
    softened(&softened(&raw, [1, 0]), [0, 1])
}

/// The published filter: the sectors are one function, turned; the brush lies along the smaller eigenvector.
fn painted(source: &Image, radius: f64, sharpness: f64, direction: f64) -> Image {
    let step = (radius / 8.0).ceil().max(1.0);
    let soft = if step == 1.0 {
        source.clone()
    } else {
        Image::from_uv(source.width, source.height, |uv| {
            let reads = (-1..=1).flat_map(|j| (-1..=1).map(move |i| [i, j]));
            reads.fold([0.0; 4], |sum, place| {
                let [i, j] = place.map(f64::from);
                let read = source.tap_offset(uv, [0.5 * step * i, 0.5 * step * j]);
                let weight = (2.0 - i.abs()) * (2.0 - j.abs()) / 16.0;
                std::array::from_fn(|c| sum[c] + weight * read[c])
            })
        })
    };
    let tensors = tensors(source);
    Image::new(source.width, source.height, |x, y| {
        let [e, f, g, _] = tensors.texel(x as i64, y as i64);
        let root = ((e - g).powi(2) + 4.0 * f * f).sqrt();
        let [large, small] = [0.5 * (e + g + root), 0.5 * (e + g - root)];
        let axis = [large - e, -f];
        let length = axis[0].hypot(axis[1]);
        let axis = if length > 0.0 { axis.map(|part| part / length) } else { [0.0, 1.0] };
        let share = 1.0 + direction * (large - small) / (large + small);
        let reach = (2.0 * radius * share / step).ceil() as i64;
        let mut sectors = [[0.0_f64; 6]; 8];
        for (j, i) in (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| (j, i))) {
            let away = [i as f64 * step, j as f64 * step];
            let p = [
                (away[0] * axis[0] + away[1] * axis[1]) / (radius * share),
                (away[1] * axis[0] - away[0] * axis[1]) * share / radius,
            ];
            if p[0] * p[0] + p[1] * p[1] > 1.0 {
                continue;
            }
            let color = soft.texel(x as i64 + away[0] as i64, y as i64 + away[1] as i64);
            let weights: [f64; 8] = std::array::from_fn(|k| {
                let (sin, cos) = (k as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
                let [along, beside] = [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]];
                (along + 0.33 - 3.77 * beside * beside).max(0.0).powi(2)
            });
            let near = (-(p[0] * p[0] + p[1] * p[1]) / (2.0 * 0.4 * 0.4)).exp() / weights.iter().sum::<f64>();
            for (sector, weight) in sectors.iter_mut().zip(weights) {
                let squares = color[..3].iter().map(|channel| channel * channel).sum();
                let [r, g, b, a] = color;
                for (sum, number) in sector.iter_mut().zip([r, g, b, a, squares, 1.0]) {
                    *sum += near * weight * number;
                }
            }
        }
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        for [r, g, b, a, squares, weight] in sectors.into_iter().filter(|sector| sector[5] > 1e-9) {
            let mean = [r, g, b, a].map(|number| number / weight);
            let variance = squares / weight - mean[..3].iter().map(|channel| channel * channel).sum::<f64>();
            let calm = 1.0 / (1.0 + (255.0 * variance.max(0.0)).powf(0.5 * sharpness));
            sum = std::array::from_fn(|c| sum[c] + calm * mean[c]);
            total += calm;
        }
        sum.map(|number| number / total)
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn strokes_are_those_of_the_published_filter() {
    // Radii of 4, 2.4 and 9 pixels; the last one has reads two pixels apart.
    for ([width, height], parameters) in
        [([23, 200], [0.02, 8.0, 1.0]), ([40, 120], [0.02, 4.0, 0.5]), ([18, 450], [0.02, 8.0, 2.0])]
    {
        let picture = drawn(width, height);
        let [radius, sharpness, direction] = parameters;
        let radii = f64::from(radius as f32) * f64::from(height);
        let wanted = painted(&image(&picture), radii, sharpness, direction);
        let node =
            format!("Kuwahara(source: \"in\", radius: {radius:?}, sharpness: {sharpness:?}, direction: {direction:?})");
        let found = made(&node, &picture);
        let pairs = found.pixels.iter().flatten().zip(wanted.pixels.iter().flatten());
        let mut off: Vec<f64> = pairs.map(|(found, wanted)| (f64::from(*found) - wanted).abs()).collect();
        off.sort_by(f64::total_cmp);
        // A read at the edge of a brush is in it or not by rounding.
        let (most, nearly_all) = (off[off.len() - 1], off[off.len() * 99 / 100]);
        assert!(nearly_all < 1e-4 && most < 0.02, "{node} at {width}x{height}: {nearly_all}, at most {most}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn paint_loses_noise_and_keeps_edges_and_flat_pictures() {
    let noise = |x: u32, y: u32| {
        let bits = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 8;
        0.05 * (bits as f32 / 8_388_608.0 - 1.0)
    };
    let step = |x: u32| if x < 20 { 0.3 } else { 0.8 };
    let picture = Picture::new(40, 300, |x, y| {
        let light = step(x) + noise(x, y);
        [light, light, light, 1.0]
    });
    let found = made("Kuwahara(source: \"in\", radius: 0.02)", &picture);
    for x in [2, 10, 18, 19, 20, 21, 30, 37] {
        for y in (0..300).step_by(7) {
            let off = (found.at(x, y)[0] - step(x)).abs();
            assert!(off < 0.03, "{off} at {x}, {y}");
        }
    }
    let flat = Picture::new(21, 60, |_, _| [0.3, 0.7, 1.0, 0.5]);
    let same = made("Kuwahara(source: \"in\", radius: 0.02)", &flat);
    let pairs = same.pixels.iter().flatten().zip(flat.pixels.iter().flatten());
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-6));
    let one = Picture::new(1, 1, |_, _| [0.3, 0.7, 1.0, 0.5]);
    let off = made("Kuwahara(source: \"in\", radius: 0.02)", &one).at(0, 0);
    assert!((0..4).all(|c| (off[c] - one.at(0, 0)[c]).abs() < 1e-6), "{off:?}");
}

/// A print of one color: dots 16 pixels apart, along the rows.
fn printed(color: [f32; 3], parameters: &str) -> Picture {
    let [r, g, b] = color;
    let flat = Picture::new(64, 64, |_, _| [r, g, b, 0.75]);
    made(&format!("Newsprint(source: \"in\", cell: 0.25, {parameters})"), &flat)
}

fn mean(picture: &Picture, channel: usize) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / picture.pixels.len() as f64
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dots_cover_what_the_picture_lacks_of_white() {
    for step in 0..=40 {
        let light = step as f32 / 40.0;
        let found = printed([light; 3], "color: false, angle: -45.0");
        assert!(found.pixels.iter().all(|pixel| pixel[0] == pixel[2] && pixel[3] == 0.75));
        let off = (mean(&found, 0) - f64::from(light)).abs();
        assert!(off < 0.006, "{light}: {off}");
        // Ink lies where the function of Holladay is largest: 0 is in the middle of the picture.
        let height = |index: usize| {
            let place = [index % 64, index / 64].map(|at| std::f64::consts::PI / 8.0 * (at as f64 + 0.5 - 32.0));
            place[0].cos() + place[1].cos()
        };
        let indices = || 0..found.pixels.len();
        let inked = indices().filter(|i| found.pixels[*i][0] < 0.01).map(height).fold(f64::INFINITY, f64::min);
        let blank = indices().filter(|i| found.pixels[*i][0] > 0.99).map(height).fold(f64::NEG_INFINITY, f64::max);
        assert!(inked >= blank - 1e-3, "{light}: ink at {inked}, paper at {blank}");
    }
    assert!(printed([1.0; 3], "").pixels.iter().all(|pixel| *pixel == [1.0, 1.0, 1.0, 0.75]));
    assert!(printed([0.0; 3], "").pixels.iter().all(|pixel| *pixel == [0.0, 0.0, 0.0, 0.75]));
    let tinted = printed([0.5; 3], "color: false, ink: (0.1, 0.2, 0.4), paper: (0.9, 0.8, 0.7)");
    for (channel, wanted) in [0.5, 0.5, 0.55].into_iter().enumerate() {
        assert!((mean(&tinted, channel) - wanted).abs() < 0.01, "{channel}: {}", mean(&tinted, channel));
    }
}

/// Screens at different angles overlap by chance: the means are the products of Demichel.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn four_inks_have_the_mean_of_the_picture() {
    for color in [[0.5, 0.5, 0.5], [0.8, 0.3, 0.1], [0.2, 0.4, 0.9], [1.0, 0.6, 0.0]] {
        for black in [0.0, 0.5, 1.0] {
            let [r, g, b] = color;
            let flat = Picture::new(512, 512, |_, _| [r, g, b, 1.0]);
            let found = made(&format!("Newsprint(source: \"in\", cell: 0.02, black: {black:?})"), &flat);
            for (channel, wanted) in color.into_iter().enumerate() {
                let off = (mean(&found, channel) - f64::from(wanted)).abs();
                assert!(off < 0.01, "{color:?} with {black} of black, channel {channel}: {off}");
            }
        }
    }
}
