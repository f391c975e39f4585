//! Dither and FilmGrain.

use super::{run, unit};
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
