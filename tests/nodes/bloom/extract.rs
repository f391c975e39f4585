//! Extract on the GPU, compared with its CPU reference.

use super::{SCENE, WHOLE, check, check_on, scaled};
use crate::reference::bloom::{self, gate_weight, knee_weight, select_emissive};
use crate::reference::color::luminance;
use crate::reference::image::rgb;
use crate::reference::math::largest;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, image};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extract_weighs_as_its_cpu_reference() {
    type Brightness = fn([f64; 3]) -> f64;
    let brightness: [(&str, Brightness); 2] = [("Max", largest), ("Luminance", luminance)];
    for (name, of) in brightness {
        let text = |method| {
            format!(
                r#""result": Extract(source: "scene", method: {method}, brightness: {name},
                    threshold: 0.5, knee: 0.25, intensity: 1.5)"#
            )
        };
        check(&text("Knee"), WHOLE, scaled(|pixel| 1.5 * knee_weight(of(rgb(pixel)), 0.5, 0.25)));
        check(&text("Gate"), WHOLE, scaled(|pixel| 1.5 * gate_weight(of(rgb(pixel)), 0.5, 0.25)));
    }
    check(r#""result": Extract(source: "scene", method: All, intensity: 0.25)"#, WHOLE, scaled(|_| 0.25));
    let hard = scaled(|pixel| knee_weight(largest(rgb(pixel)), 1.0, 0.0));
    check(r#""result": Extract(source: "scene", knee: 0.0)"#, WHOLE, hard);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extract_takes_emission_from_alpha() {
    let nodes = r#""result": Extract(source: "scene", method: Emissive, threshold: 0.5, intensity: 2.0)"#;
    check(nodes, WHOLE, |image| {
        image.map(|pixel| {
            let [r, g, b] = select_emissive(pixel, 0.5, 2.0);
            [r, g, b, pixel[3]]
        })
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_mask_of_one_is_selected_by_default() {
    let scene = Picture::new(2, 1, |x, _| [0.5, 0.25, 0.125, x as f32]);
    let selected = Picture::new(2, 1, |x, _| [0.5, 0.25, 0.125, 1.0].map(|value| value * x as f32));
    check_on(r#""result": Extract(source: "scene", method: Emissive)"#, &scene, &image(&selected), WHOLE);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_gate_without_edges_lets_all_but_black_pass() {
    let scene = Picture::new(2, 1, |x, _| [x as f32 * 1e-3, 0.0, 0.0, 1.0]);
    let nodes = r#""result": Extract(source: "scene", method: Gate, threshold: 0.0, knee: 0.0)"#;
    check_on(nodes, &scene, &image(&scene), WHOLE);
}

/// The deck's clamp is the exponential curve and then a gate: the vectors `glare_extract` of the formula book.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_clamp_after_the_exponential_curve_is_the_deck_s() {
    let scene = Picture::new(6, 1, |x, _| {
        [[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3], [10.0; 3], [5.0, 0.2, 0.1]].map(|[r, g, b]| [r, g, b, 1.0])[x as usize]
    });
    let nodes = r#"
        "exposed": Exposure(source: "scene", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: Exponential, middle_gray: Native, keep_hue: 0.0, gamut: Clip),
        "result": Extract(source: "mapped", method: Clamp)"#;
    let result = &Nodes::new(nodes, SCENE).exact(&[&scene]);
    let printed = [0.0, 0.0, 0.425441201, 1.6057573, 1.99990889, 0.0];
    for (x, want) in printed.into_iter().enumerate() {
        let got = f64::from(result.pixels[x][0]);
        assert!((got - want).abs() <= 2e-6 + 1e-5 * want, "{x}: {got}, expected {want}");
        let reference = bloom::glare(rgb(scene.pixels[x].map(f64::from)), 1.0)[0];
        assert!((got - reference).abs() <= 2e-6 + 1e-5 * reference, "{x}: {got}, the CPU reference has {reference}");
    }
}
