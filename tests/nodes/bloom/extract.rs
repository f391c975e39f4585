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

/// Light of fixed colors from 2^-12 to 2^6, a row for each: gray, saturated, and of a wide gamut in Rec.709. Alpha is
/// up to 4.
fn ramps() -> Picture {
    let colors = [[1.0, 1.0, 1.0], [0.02, 0.1, 1.0], [1.0, -0.2, 0.1], [-0.3, 1.0, -0.1], [0.0, 0.0, 0.0]];
    Picture::new(512, colors.len() as u32, |x, y| {
        let light = (-12.0 + 18.0 * x as f32 / 511.0).exp2();
        let [r, g, b] = colors[y as usize].map(|share: f32| share * light);
        [r, g, b, 4.0 * x as f32 / 511.0]
    })
}

/// The judge is the source: what is selected from light is a part of it, and more of more light.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_selection_is_brighter_than_its_source_and_none_falls_or_jumps() {
    let source = ramps();
    let width = source.width as usize;
    let edges = [0.0_f32, 0.001, 0.05, 0.2, 1.0, 8.0];
    let soft = ["Knee", "Gate"].into_iter().flat_map(|method| ["Max", "Luminance"].map(|of| (method, of)));
    let soft = soft.flat_map(|of| edges.into_iter().flat_map(move |edge| edges.map(|knee| (of, edge, knee))));
    let others = ["All", "Emissive", "Clamp"].map(|method| ((method, "Max"), 0.0, 0.1));
    for ((method, of), threshold, knee) in soft.chain(others) {
        let name = format!("method: {method}, brightness: {of}, threshold: {threshold:?}, knee: {knee:?}");
        let selected = Nodes::new(&format!("\"result\": Extract(source: \"scene\", {name})"), SCENE).exact(&[&source]);
        // The clamp doubles, and opens over a fifth.
        let (factor, reach) = if method == "Clamp" { (2.0, 0.1) } else { (1.0, knee.min(threshold)) };
        // The steepest slope of light times the share that a gate lets pass.
        let steepest = match method {
            "Gate" if reach == 0.0 => f32::INFINITY,
            "Gate" => 1.0 + 0.75 * (threshold + reach) / reach,
            "Clamp" => 2.0 * (1.0 + 0.75 * 1.0 / 0.1),
            "Emissive" => 4.0,
            _ => 1.0,
        };
        let pairs = source.pixels.iter().zip(&selected.pixels).enumerate();
        for (index, (light, found)) in pairs.filter(|(index, _)| index % width > 0) {
            let [light_before, before] = [source.pixels[index - 1], selected.pixels[index - 1]];
            for c in 0..3 {
                let (most, found, before) = (factor * light[c].abs(), found[c] * light[c].signum(), before[c].abs());
                assert!(found >= 0.0 && found <= 1.000_001 * most, "{name}: {found} of {}", light[c]);
                assert!(found >= 0.999_999 * before, "{name}: {found} of {} after {before}", light[c]);
                let step = (light[c] - light_before[c]).abs();
                let most = if step == 0.0 { 0.0 } else { steepest * step };
                assert!(found - before <= 1.001 * most + 1e-7, "{name}: {found} of {} after {before}", light[c]);
            }
        }
    }
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
