//! Sharpening, anti-aliasing and lenses on the GPU: what their CPU references do not say.

use crate::reference::fxaa::{Fxaa, STEPS};
use crate::reference::image::Image;
use crate::reference::smaa::Smaa;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, differences, image};
use crate::support::numbers::Numbers;
use crate::support::sweep;

/// Few lights in the dark, up to 60 times white.
pub(super) fn lights([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    Picture::new(width, height, |x, _| {
        let is_light = numbers.next() < 0.03;
        let strength = if is_light { 60.0 * numbers.next() } else { 0.1 };
        let color = [0, 1, 2].map(|_| (strength * numbers.next()) as f32);
        [color[0], color[1], color[2], (x % 3) as f32 * 0.5]
    })
}

/// A color, and the half-plane a·u + b·v + c > 0 that has it.
type HalfPlane = ([f64; 3], [f64; 3]);

const EDGES: [HalfPlane; 4] = [
    ([0.83, 0.61, 0.27], [0.131, -1.0, 0.31]),
    ([0.12, 0.34, 0.71], [-1.0, 0.237, 0.62]),
    ([0.47, 0.88, 0.35], [0.713, 1.0, -1.32]),
    ([0.05, 0.03, 0.09], [-1.0, -0.387, 0.41]),
];

/// Nearly level, nearly upright and nearly diagonal edges of an image of 161x97 pixels: one step in 45 and 37 pixels,
/// and staircases that are longer than 8 steps.
const STAIRCASES: [HalfPlane; 4] = [
    ([0.83, 0.61, 0.27], [161.0, -45.0 * 97.0, 800.0]),
    ([0.12, 0.34, 0.71], [-37.0 * 161.0, 97.0, 5000.0]),
    ([0.47, 0.88, 0.35], [1.06 * 161.0, 97.0, -201.0]),
    ([0.05, 0.03, 0.09], [-0.93 * 161.0, 97.0, -22.0]),
];

/// The color at a place: the last half-plane that contains it.
fn plane(planes: &[HalfPlane], [u, v]: [f64; 2]) -> [f64; 3] {
    let inside = |(_, [a, b, c]): &&HalfPlane| a * u + b * v + c > 0.0;
    planes.iter().rev().find(inside).map_or([0.93, 0.95, 0.86], |(color, _)| *color)
}

/// Edges in four directions, one sample a pixel.
pub(super) fn aliased(size: [u32; 2]) -> Picture {
    aliased_planes(&EDGES, size)
}

/// One sample of the half-planes in each pixel, a little brighter or darker from pixel to pixel, so that no two
/// brightnesses are equal.
fn aliased_planes(planes: &[HalfPlane], [width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    Picture::new(width, height, |x, y| {
        let uv = [(f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height)];
        let [r, g, b] = plane(planes, uv).map(|light| (light + 0.03 * (numbers.next() - 0.5)) as f32);
        [r, g, b, (x % 5) as f32 * 0.25]
    })
}

/// The half-planes with 256 samples a pixel.
fn supersampled(planes: &[HalfPlane], [width, height]: [usize; 2]) -> Image {
    Image::new(width, height, |x, y| {
        let place = |i: usize, j: usize| {
            [(x as f64 + (i as f64 + 0.5) / 16.0) / width as f64, (y as f64 + (j as f64 + 0.5) / 16.0) / height as f64]
        };
        let mut sum = [0.0; 3];
        for color in (0..256).map(|k| plane(planes, place(k % 16, k / 16))) {
            sum = [0, 1, 2].map(|c| sum[c] + color[c] / 256.0);
        }
        [sum[0], sum[1], sum[2], 1.0]
    })
}

fn mean_square(found: &Picture, wanted: &Image) -> f64 {
    let squares = found.pixels.iter().zip(&wanted.pixels);
    let sum: f64 = squares.map(|(a, b)| (0..3).map(|c| (f64::from(a[c]) - b[c]).powi(2)).sum::<f64>()).sum();
    sum / found.pixels.len() as f64
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_search_of_fxaa_equals_the_published_one_and_comes_nearer_to_the_supersampled_image() {
    let picture = aliased([161, 97]);
    let wanted = supersampled(&EDGES, [161, 97]);
    let before = mean_square(&picture, &wanted);
    let mut errors = Vec::new();
    for (state, is_light) in [("Encoded", false), ("DisplayLinear", true)] {
        for (search, steps) in ["Long", "Medium", "Short"].into_iter().zip(STEPS) {
            let fxaa = Fxaa { subpixel: 0.5, threshold: 0.166, floor: 0.05, steps, is_light };
            let text = format!(
                "\"result\": Fxaa(source: \"in\", search: {search}, subpixel: 0.5, threshold: 0.166, floor: 0.05)"
            );
            let found = Nodes::new(&text, &[("in", state)]).exact(&[&picture]);
            let reason = "the place of the last read is a quotient of distances in f32";
            let tolerance = Tolerance { absolute: 1e-6, relative: 2e-4, of: Scale::Neighborhood, reason };
            // Whether an edge ends at a read between two pixels is a tie but for the noise: f32 may decide otherwise.
            let differ = differences(&found, &fxaa.apply(&image(&picture)), &tolerance);
            assert!(differ.len() <= 8, "{search} in {state}: {} pixels\n{}", differ.len(), differ[..4].join("\n"));
            errors.push(mean_square(&found, &wanted) / before);
        }
    }
    assert!(errors.iter().all(|share| *share < 0.6), "{errors:?}");
}

/// The error of each search of Smaa as a share of the error of the aliased image, and last that of Fxaa.
fn errors_of_smaa(planes: &[HalfPlane], state: &str) -> [f64; 4] {
    let picture = aliased_planes(planes, [161, 97]);
    let wanted = supersampled(planes, [161, 97]);
    let rendered = |node: &str| Nodes::new(&format!("\"result\": {node}"), &[("in", state)]).exact(&[&picture]);
    let error = |found: &Picture| mean_square(found, &wanted) / mean_square(&picture, &wanted);
    let mut errors = [0.0; 4];
    for (index, (search, reach, diagonals)) in [("Far", 64, 16), ("Middle", 32, 8), ("Near", 16, 0)].iter().enumerate()
    {
        let is_light = state == "DisplayLinear";
        let smaa = Smaa { threshold: 0.08, corners: 0.5, reach: *reach, diagonals: *diagonals, is_light };
        let found = rendered(&format!("Smaa(source: \"in\", search: {search}, threshold: 0.08, corners: 0.5)"));
        let reason = "shares are quotients in f32";
        let tolerance = Tolerance { absolute: 1e-6, relative: 2e-5, of: Scale::Neighborhood, reason };
        assert_close(search, &found, &smaa.apply(&image(&picture)), &tolerance);
        errors[index] = error(&found);
    }
    errors[3] = error(&rendered("Fxaa(source: \"in\")"));
    errors
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_search_of_smaa_equals_its_reference_and_comes_nearer_to_the_supersampled_image_than_fxaa() {
    for state in ["Encoded", "DisplayLinear"] {
        let [far, middle, near, fxaa] = errors_of_smaa(&EDGES, state);
        assert!(far.max(middle).max(near) < 0.8 * fxaa, "{state}: {far} {middle} {near}, Fxaa {fxaa}");
        let [far, middle, near, fxaa] = errors_of_smaa(&STAIRCASES, state);
        assert!(far < middle && middle < 0.9 * near, "{state}: {far} {middle} {near}");
        assert!(middle < 0.9 * fxaa, "{state}: {middle}, Fxaa {fxaa}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_sharpened_edge_has_no_halo_and_is_steeper() {
    // A soft edge, as of a scaled image.
    let ramp = [0.2, 0.2, 0.2, 0.26, 0.5, 0.74, 0.8, 0.8, 0.8_f32];
    let edge = Picture::new(9, 5, |x, _| [ramp[x as usize], ramp[x as usize], ramp[x as usize], 1.0]);
    for node in ["Sharpen(source: \"in\", amount: 2.0)", "Cas(source: \"in\", sharpness: 1.0)"] {
        let sharp = Nodes::new(&format!("\"result\": {node}"), &[("in", "DisplayLinear")]).exact(&[&edge]);
        let row: Vec<f32> = (0..9).map(|x| sharp.at(x, 2)[0]).collect();
        assert!(row[5] - row[3] > 0.55, "{node}: {row:?}");
        let slack = if node.starts_with("Sharpen") { 1e-6 } else { 0.08 };
        assert!(row.iter().all(|x| (0.2 - slack..=0.8 + slack).contains(x)), "{node}: {row:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn dirt_of_an_image_is_read_at_the_same_place() {
    let light = Picture::new(8, 4, |x, _| [1.0 + x as f32, 2.0, 0.5, 1.0]);
    let dirt = Picture::new(4, 2, |x, y| [x as f32, y as f32, 0.5, 1.0]);
    let nodes = "\"result\": LensDirt(source: \"light\", dirt: \"dirt\", strength: 2.0)";
    let found = Nodes::new(nodes, &[("light", "Exposed"), ("dirt", "Data")]).exact(&[&light, &dirt]);
    let (light, dirt) = (image(&light), image(&dirt));
    let wanted = Image::from_uv(8, 4, |uv| {
        let (light, dirt) = (light.tap(uv), dirt.tap(uv));
        [0, 1, 2, 3].map(|c| if c < 3 { light[c] * (1.0 + 2.0 * dirt[c]) } else { light[c] })
    });
    let tolerance = Tolerance { absolute: 1e-5, relative: 4e-3, of: Scale::Pixel, reason: "a sampled image" };
    assert_close("dirt", &found, &wanted, &tolerance);
}

/// The light's sum along a row or a column, and its mean square distance from the light.
fn spread(image: &Picture, at: u32, axis: usize) -> [f64; 2] {
    let (mut sum, mut square) = (0.0, 0.0);
    for (index, pixel) in image.pixels.iter().enumerate() {
        let place = [index as u32 % image.width, index as u32 / image.width];
        let light = f64::from(pixel[0]);
        sum += light;
        square += light * (f64::from(place[axis]) - f64::from(at)).powi(2);
    }
    [sum, square / sum]
}

/// The glow of one pixel with all of its light spread, as shares of its energy and of the standard deviation asked for,
/// in x and y.
fn halation_of_a_pixel(size: [u32; 2], at: [u32; 2], sigma: f64) -> [[f64; 2]; 2] {
    let radius = sigma / f64::from(size[1]);
    let node = format!("Halation(source: \"scene\", strength: 1.0, tint: (1.0, 1.0, 1.0), radius: {radius:.7})");
    blur_of_a_pixel(&node, size, at, sigma)
}

/// The same of any node that blurs by that many pixels.
fn blur_of_a_pixel(node: &str, size: [u32; 2], at: [u32; 2], sigma: f64) -> [[f64; 2]; 2] {
    let text = format!("\"result\": {node}");
    let light = Picture::new(size[0], size[1], |x, y| [if [x, y] == at { 1000.0 } else { 0.0 }, 0.0, 0.0, 1.0]);
    let shown = Nodes::new(&text, &[("scene", "Exposed")]).exact(&[&light]);
    [0, 1].map(|axis| {
        let [energy, square] = spread(&shown, at[axis], axis);
        [energy / 1000.0, square.sqrt() / sigma]
    })
}

/// The judge is the definition: the second moment of the light that a pixel spreads.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn halation_keeps_energy_and_width_at_every_size() {
    let odd = sweep::some([[257, 256], [256, 257], [257, 257], [255, 255], [253, 251]], 2);
    for size in [[256, 256]].into_iter().chain(odd) {
        for at in [[128, 128], [129, 128], [128, 129], [127, 127]] {
            for [energy, width] in halation_of_a_pixel(size, at, 0.07 * f64::from(size[1])) {
                assert!((energy - 1.0).abs() < 1e-3, "{size:?} {at:?}: {energy}");
                assert!((width - 1.0).abs() < 0.02, "{size:?} {at:?}: {width} of the sigma");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kind is")]
fn halation_is_as_wide_as_its_radius_says_on_both_sides_of_a_halving() {
    // Halvings begin at sigmas of 4, 8 and 16 pixels.
    for sigma in [0.3, 0.5, 1.0, 2.0, 3.0, 3.5, 3.98, 4.02, 4.5, 5.5, 7.0, 7.95, 8.05, 9.0, 12.0, 15.9, 16.1, 19.0] {
        for at in [[80, 80], [81, 83]] {
            let found = halation_of_a_pixel([160, 160], at, sigma);
            println!("a sigma of {sigma} at {at:?}: {found:.4?}");
            for [energy, width] in found {
                assert!((energy - 1.0).abs() < 1e-3 && (width - 1.0).abs() < 0.005, "{sigma} at {at:?}: {width}");
            }
        }
    }
}

/// The judge is the definition of the width.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_gaussian_of_halved_taps_keeps_energy_and_width() {
    for size in [[256, 256], [257, 255]] {
        for (lines, sigma) in [(128, 1.5), (128, 2.0), (64, 2.0), (32, 3.0)] {
            let node =
                format!("Gaussian(source: \"scene\", sigma: {sigma:?}, reach: 4.0, lines: {lines}, taps: Halved)");
            let pixels = sigma * f64::from(size[1]) / f64::from(lines);
            for at in [[128, 128], [129, 127]] {
                for [energy, width] in blur_of_a_pixel(&node, size, at, pixels) {
                    assert!((energy - 1.0).abs() < 1e-3, "{size:?} {lines} {sigma} {at:?}: {energy}");
                    assert!((width - 1.0).abs() < 0.01, "{size:?} {lines} {sigma} {at:?}: {width} of the sigma");
                }
            }
        }
    }
}

/// A disc with stripes, some of them half transparent, before nothing; `at` is the place of its middle.
pub(super) fn on_glass(size: [u32; 2], at: [f32; 2]) -> Picture {
    Picture::new(size[0], size[1], |x, y| {
        let is_disc = (x as f32 - at[0]).hypot(y as f32 - at[1]) < 14.0;
        let alpha = if !is_disc {
            0.0
        } else if (x / 5) % 2 == 0 {
            1.0
        } else {
            0.5
        };
        [0.8 * alpha, 0.3 * alpha, 0.1 * alpha, alpha]
    })
}

/// A picture over a background of one light.
pub(super) fn over(picture: &Picture, background: f32) -> Picture {
    let Picture { width, height, .. } = *picture;
    Picture::new(width, height, |x, y| {
        let [r, g, b, a] = picture.at(x, y);
        let [r, g, b] = [r, g, b].map(|light| light + (1.0 - a) * background);
        [r, g, b, 1.0]
    })
}

/// The largest difference of two pictures.
pub(super) fn apart(one: &Picture, other: &Picture) -> f32 {
    let pairs = one.pixels.iter().zip(&other.pixels);
    pairs.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
}

/// The judge is the same node on the picture over a background: what it makes of light and alpha, over that background.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn blurs_of_a_transparent_picture_lie_over_any_background() {
    let size = [72, 60];
    let glass = on_glass(size, [35.0, 29.0]);
    let is_disc = |x: u32, y: u32| glass.at(x, y)[3] > 0.0;
    let depth = Picture::new(size[0], size[1], |x, y| [if is_disc(x, y) { 1.5 } else { 5.0 }, 0.0, 0.0, 1.0]);
    let motion = Picture::new(size[0], size[1], |x, y| if is_disc(x, y) { [9.0, 4.0, 0.0, 1.0] } else { [0.0; 4] });
    let lens = "DepthOfField(source: \"in\", depth: \"depth\", focal_length: 100.0, largest: 0.1, FOCUS)";
    for text in [
        &lens.replace("FOCUS", "focus: 5.0"),
        &lens.replace("FOCUS", "focus: 1.5"),
        &lens.replace("FOCUS", "focus: 3.0, blades: 6"),
        "MotionBlur(source: \"in\", motion: \"motion\", depth: \"depth\", unit: Pixels, shutter: 360.0, largest: 0.1)",
        "MotionBlur(source: \"in\", motion: \"motion\", unit: Pixels, shutter: 360.0, largest: 0.1)",
    ] {
        let nodes = format!("\"result\": {text}");
        let nodes = Nodes::new(&nodes, &[("in", "Color"), ("depth", "Depth"), ("motion", "Motion")]);
        let blurred = nodes.exact(&[&glass, &depth, &motion]);
        // There is nothing to see behind a disc in focus.
        let is_blurred = apart(&blurred, &glass) > 0.2;
        assert!(is_blurred || text.contains("focus: 1.5"), "{text}: nothing is blurred");
        for background in [0.0, 1.0, 20.0] {
            let wanted = nodes.exact(&[&over(&glass, background), &depth, &motion]);
            let off = apart(&over(&blurred, background), &wanted) / background.max(1.0);
            assert!(off < 1e-4, "{text} over {background}: off by {off}");
            assert!(wanted.pixels.iter().all(|pixel| (pixel[3] - 1.0).abs() < 1e-6), "{text}: it is opaque");
        }
    }
}
