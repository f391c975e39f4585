//! Dither and FilmGrain.

use super::{run, unit};
use crate::reference::film_grain::Grain;
use crate::reference::transfer::{dither, quantize};
use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;
use afterimage_graph::check::NoFiles;

/// PCG3D, once more.
fn hash3(seed: [u32; 3]) -> [u32; 3] {
    let [mut x, mut y, mut z] = seed.map(|v| v.wrapping_mul(1664525).wrapping_add(1013904223));
    let round = |x: &mut u32, y: &mut u32, z: &mut u32| {
        *x = x.wrapping_add(y.wrapping_mul(*z));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
    };
    round(&mut x, &mut y, &mut z);
    for v in [&mut x, &mut y, &mut z] {
        *v ^= *v >> 16;
    }
    round(&mut x, &mut y, &mut z);
    [x, y, z]
}

/// The two random numbers of a channel of a pixel.
pub(in crate::nodes) fn random(x: u32, y: u32, channel: usize, seed: u32) -> [f64; 2] {
    let h = hash3([x, y, seed])[channel];
    [f64::from(h >> 16) / 65536.0, f64::from(h & 0xffff) / 65536.0]
}

fn codes(pixel: [f32; 4], bits: u32) -> [f64; 3] {
    [0, 1, 2].map(|channel| quantize(f64::from(pixel[channel]), bits))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dither_gives_the_codes_of_its_cpu_reference() {
    let input = unit([61, 37]);
    for (bits, seed) in [(8, 0), (10, 7), (1, 65535)] {
        let output = run("Encoded", &format!("Dither(bits: {bits}, seed: {seed})"), &NoFiles, &input);
        let mut off = 0;
        for y in 0..37 {
            for x in 0..61 {
                let found = codes(output.at(x, y), bits);
                for (channel, found) in found.into_iter().enumerate() {
                    let [u1, u2] = random(x, y, channel, seed);
                    let expected = dither(f64::from(input.at(x, y)[channel]), u1, u2, bits);
                    assert!((found - expected).abs() <= 1.0);
                    off += usize::from(found != expected);
                }
            }
        }
        // A value that lies on the border of two codes in 64 bits may lie beside it in 32.
        assert!(off <= 3, "{off} of 6771 codes at {bits} bits");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dithered_values_are_codes_even_in_half_floats() {
    for bits in [8, 10, 11, 12] {
        let node = format!("Dither(source: \"in\", bits: {bits})");
        let text = format!(
            "Pipeline(inputs: {{ \"in\": Encoded }}, nodes: {{ \"out\": {node} }}, outputs: {{ \"out\": \"out\" }})"
        );
        let graph = crate::support::gpu::graph(&text);
        let input = unit([61, 37]);
        let halves = Run::new(&graph).frame(&[("in", &input)]).remove(0);
        let exact = Run::new(&graph).exact().frame(&[("in", &input)]).remove(0);
        for (half, exact) in halves.pixels.iter().zip(&exact.pixels) {
            assert_eq!(codes(*half, bits), codes(*exact, bits), "{bits} bits");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn solid_black_and_white_stay_solid_and_flat_areas_keep_their_mean() {
    for (value, code) in [(0.0, Some(0.0)), (1.0, Some(255.0)), (0.30137, None), (0.00261, None)] {
        let flat = Picture::new(128, 128, |_, _| [value, value, value, 1.0]);
        let output = run("Encoded", "Dither()", &NoFiles, &flat);
        let all: Vec<f64> = output.pixels.iter().flat_map(|pixel| codes(*pixel, 8)).collect();
        match code {
            Some(code) => assert!(all.iter().all(|found| *found == code)),
            None => {
                let mean = all.iter().sum::<f64>() / all.len() as f64;
                assert!((mean - f64::from(value) * 255.0).abs() < 0.01, "{value}: {mean}");
                assert!(all.iter().any(|found| *found != all[0]));
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn only_animated_noise_changes_from_frame_to_frame() {
    let input = unit([31, 17]);
    let frames = |node: &str| {
        let graph = Nodes::new(&super::on_source(node), &[("in", "Encoded")]).graph();
        let frames = Run::new(&graph).exact().frames(&[("in", &input)], &[(0.0, true), (0.04, false)]);
        (frames[0][0].clone(), frames[1][0].clone())
    };
    for kind in ["Dither", "FilmGrain"] {
        let (first, second) = frames(&format!("{kind}(animate: true)"));
        assert!(first != second, "{kind}");
        let (first, second) = frames(&format!("{kind}(animate: false)"));
        assert!(first == second, "{kind}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grain_keeps_black_white_and_the_mean_and_stays_in_range() {
    for size in ["1.0", "1.5", "7.3"] {
        let node = format!("FilmGrain(amount: 1.0, size: {size}, color: 0.5, animate: false)");
        for (value, least_spread, most_spread) in
            [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.02, 0.25), (0.1, 0.005, 0.09)]
        {
            let flat = Picture::new(256, 256, |_, _| [value, value, value, 0.7]);
            let output = run("Encoded", &node, &NoFiles, &flat);
            let all: Vec<f64> =
                output.pixels.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]].map(f64::from)).collect();
            assert!(all.iter().all(|x| (0.0..=1.0).contains(x)), "{node} at {value}");
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let spread = (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt();
            assert!((mean - f64::from(value)).abs() < 0.01, "{node} at {value}: mean {mean}");
            assert!((least_spread..=most_spread).contains(&spread), "{node} at {value}: spread {spread}");
            assert!(output.pixels.iter().all(|pixel| pixel[3] == 0.7));
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grain_of_silver_has_no_color_and_a_seed_of_its_own() {
    let flat = Picture::new(64, 64, |_, _| [0.4, 0.4, 0.4, 1.0]);
    let grain = |seed: u32| run("Encoded", &format!("FilmGrain(color: 0.0, seed: {seed})"), &NoFiles, &flat);
    let (one, other) = (grain(1), grain(2));
    assert!(one.pixels.iter().all(|[r, g, b, _]| r == g && g == b));
    let same = one.pixels.iter().zip(&other.pixels).filter(|(a, b)| a == b).count();
    assert!(same < 64, "{same} pixels of two seeds are equal");
}

/// The grain of an image of that size, monochrome and of pixels in 0..1 of gray 0.5, in rows.
fn gray_grain(width: u32, height: u32, size: f32) -> Vec<f64> {
    let flat = Picture::new(width, height, |_, _| [0.5, 0.5, 0.5, 1.0]);
    let node = format!("FilmGrain(amount: 1.0, size: {size:?}, color: 0.0, animate: false)");
    run("Encoded", &node, &NoFiles, &flat).pixels.iter().map(|pixel| 4.0 * (f64::from(pixel[0]) - 0.5)).collect()
}

/// The mean product of pixels of rows of that width at this distance, over the mean square.
fn correlation(field: &[f64], width: usize, [dx, dy]: [usize; 2]) -> f64 {
    let height = field.len() / width;
    let pairs = (0..height - dy).flat_map(|y| (0..width - dx).map(move |x| (x + width * y, x + dx + width * (y + dy))));
    let products: Vec<f64> = pairs.map(|(one, other)| field[one] * field[other]).collect();
    let square = field.iter().map(|x| x * x).sum::<f64>() / field.len() as f64;
    products.iter().sum::<f64>() / products.len() as f64 / square
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grain_from_tiles_is_that_of_the_model() {
    let flat = Picture::new(1024, 512, |x, _| [0.2 + 0.6 * x as f32 / 1024.0, 0.5, 0.4, 0.7]);
    let node = "FilmGrain(amount: 0.5, size: 1.7, color: 0.4, seed: 3, animate: false)";
    let output = run("Encoded", node, &NoFiles, &flat);
    let grain = Grain { amount: 0.5, size: 1.7, color: 0.4, seed: 3 };
    for (x, y) in (0..512).step_by(3).flat_map(|y| (0..1024).step_by(5).map(move |x| (x, y))) {
        let rgb = flat.at(x, y);
        let expected = grain.apply_tiles([0, 1, 2].map(|k| f64::from(rgb[k])), [x as usize, y as usize], [1024, 512]);
        let found = output.at(x, y);
        let off = [0, 1, 2].map(|k| (f64::from(found[k]) - expected[k]).abs()).into_iter().fold(0.0, f64::max);
        assert!(off < 1e-4 && found[3] == 0.7, "{found:?} is not {expected:?} at {x}, {y}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grain_from_tiles_looks_like_grain_and_has_no_seams() {
    for size in [1.5, 3.3] {
        let (direct, tiled, width) = (gray_grain(512, 512, size), gray_grain(1024, 720, size), 1024);
        let variance = |field: &[f64]| 8.0 * field.iter().map(|x| x * x).sum::<f64>() / field.len() as f64;
        let (wanted, found) = (variance(&direct), variance(&tiled));
        assert!((found / wanted - 1.0).abs() < 0.04, "size {size}: variance {found}, not {wanted}");
        for lag in [[1, 0], [0, 1], [1, 1], [2, 0], [0, 3], [5, 5], [128, 0], [200, 133]] {
            let (wanted, found) = (correlation(&direct, 512, lag), correlation(&tiled, width, lag));
            assert!((found - wanted).abs() < 0.03, "size {size}: correlation {found}, not {wanted} at {lag:?}");
        }
        // Where one of the two tiles begins again.
        for lag in [[256, 0], [0, 256], [239, 0], [0, 239], [512, 256], [478, 0], [256, 256]] {
            let found = correlation(&tiled, width, lag);
            assert!(found.abs() < 0.1, "size {size}: correlation {found} at {lag:?}");
        }
        // The mean square of the difference between neighbors, over each column and over each row. At the border of a
        // tile that is not periodic it is six times the mean, where grains are larger than pixels.
        let step = |one: usize, other: usize| (tiled[one] - tiled[other]).powi(2);
        let columns =
            (0..width - 1).map(|x| (0..720).map(|y| step(x + width * y, x + 1 + width * y)).sum::<f64>() / 720.0);
        let rows = (0..719).map(|y| (0..width).map(|x| step(x + width * y, x + width * (y + 1))).sum::<f64>() / 1024.0);
        let steps: Vec<f64> = columns.chain(rows).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let largest = steps.iter().copied().fold(0.0, f64::max);
        assert!(size < 3.0 || largest < 2.5 * mean, "size {size}: a seam of {largest} between steps of {mean}");
    }
}

/// A size for an image of other lines is scaled, and no grain is smaller than a pixel.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grains_of_an_image_of_more_lines_are_larger() {
    for size in [[64, 48], [1024, 768]] {
        let input = unit(size);
        let grain = |size: f32, lines: f32| {
            let node = format!("FilmGrain(size: {size:?}, lines: {lines:?}, animate: false)");
            run("Encoded", &node, &NoFiles, &input)
        };
        let height = size[1] as f32;
        assert!(grain(1.5, 0.5 * height) == grain(3.0, 0.0));
        assert!(grain(1.5, height) == grain(1.5, 0.0));
        assert!(grain(1.5, 8.0 * height) == grain(1.0, 0.0));
    }
}
