//! Shadows on the GPU: what their CPU reference does not say.

use super::surface::eye;
use crate::support::gpu::Picture;
use crate::support::harness::Nodes;
use crate::support::sweep;

/// A plane as the eye sees it: the inverse of the distance is linear in the image.
fn plane(side: u32, [across, down]: [f32; 2]) -> Picture {
    Picture::new(side, side, |x, y| {
        let [u, v] = [x, y].map(|at| (at as f32 + 0.5) / side as f32);
        [1.0 / (0.3 + across * u + down * v), 0.0, 0.0, 1.0]
    })
}

/// The depths of distances in the eye's projection, whose near plane is at depth 1.
fn written(distances: &Picture) -> Picture {
    Picture::new(distances.width, distances.height, |x, y| [0.1 / distances.at(x, y)[0], 0.0, 0.0, 1.0])
}

/// The share of the eye's own light that is blocked.
fn shadow(parameters: &str, depth: &Picture, map: &Picture) -> Picture {
    let text = format!(
        "\"mask\": ShadowMask(source: \"in\", depth: \"depth\", camera: \"camera\", map: \"map\", light: \"camera\", \
         {parameters}) -> mask.shadow"
    );
    let inputs = [("in", "Color"), ("depth", "Depth"), ("map", "Depth")];
    let gray = Picture::new(depth.width, depth.height, |_, _| [0.5, 0.4, 0.3, 0.2]);
    Nodes::new(&text, &inputs).camera(Some(&eye())).exact(&[&gray, depth, map])
}

/// The light sees a sloping plane in texels that are six times as large as pixels.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plane_never_shadows_itself_with_a_slope_bias_of_one() {
    for slope in [[0.0, 0.0], [0.25, 0.0], [0.0, -0.2], [0.4, 0.3], [1.5, -0.1]] {
        let (depth, map) = (plane(96, slope), written(&plane(16, slope)));
        for kernel in (1..=7).step_by(if sweep::is_whole() { 1 } else { 3 }) {
            for pattern in ["Square", "Disc"] {
                let of = |bias: &str| {
                    let found = shadow(&format!("kernel: {kernel}, pattern: {pattern}, {bias}"), &depth, &map);
                    found.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max)
                };
                assert_eq!(of("bias: 0.001"), 0.0, "{slope:?}, {kernel}, {pattern}");
                let acne = of("bias: 0.001, slope_bias: 0.0");
                assert!(slope == [0.0; 2] || acne > 0.1, "{slope:?}, {kernel}, {pattern}: {acne} without a slope bias");
            }
            for diameter in [0.05, 0.5].into_iter().filter(|_| kernel % 3 == 1) {
                let size = format!("light_diameter: {diameter}, largest: 0.5, kernel: {kernel}, bias: 0.001");
                let found = shadow(&size, &depth, &map);
                let most = found.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
                assert_eq!(most, 0.0, "{slope:?}, {size}");
            }
        }
    }
}

/// A wall one meter before the plane, in the left half of the map.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_shadow_has_its_sides_and_an_edge_as_wide_as_the_kernel() {
    let depth = Picture::new(64, 16, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let map = Picture::new(64, 16, |x, _| [0.1 / if x < 32 { 2.0 } else { 3.0 }, 0.0, 0.0, 1.0]);
    for kernel in [1, 2, 5] {
        let found = shadow(&format!("kernel: {kernel}"), &depth, &map);
        let row: Vec<f32> = (0..64).map(|x| found.at(x, 8)[0]).collect();
        let soft = row[8..].iter().filter(|share| (0.001..0.999).contains(*share)).count();
        assert!(row[8..24].iter().all(|share| *share == 1.0) && row[40..].iter().all(|share| *share == 0.0));
        assert!(row[8..].is_sorted_by(|a, b| a >= b) && soft < kernel + 1, "{kernel}: {row:?}");
    }
}

/// A wall before the plane, as far from it as it is from the light and half as far, in the left half of the map.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn penumbrae_grow_with_the_distance_of_the_blocker_as_triangles_do() {
    let depth = Picture::new(256, 32, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let texel = 2.0 * 3.0 * (0.5 * 1.1_f32).tan() * 1.5 / 256.0;
    let soft = |wall: f32| {
        let map = Picture::new(256, 32, |x, _| [0.1 / if x < 128 { wall } else { 3.0 }, 0.0, 0.0, 1.0]);
        let size = "light_diameter: 0.4, largest: 0.2, kernel: 1, taps: 64, blocker_taps: 64";
        let found = shadow(size, &depth, &map);
        let mean = |x: u32| (12..20).map(|y| found.at(x, y)[0]).sum::<f32>() / 8.0;
        let row: Vec<f32> = (16..240).map(mean).collect();
        assert_eq!((row[0], row[223]), (1.0, 0.0), "both sides of {wall} m");
        // The share of a disc before an edge is 0.02 and 0.98 at nine tenths of its width.
        row.iter().filter(|share| (0.02..0.98).contains(*share)).count() as f32 * texel
    };
    for wall in [2.0, 1.5] {
        let wanted = 0.4 * (3.0 - wall) / wall;
        let found = soft(wall);
        assert!((found / wanted - 0.9).abs() < 0.15, "{wall} m: {found} m instead of {wanted} m");
    }
}

/// A size of 0 is no size, and neither is that of the other kind of light.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_light_without_a_size_has_the_shadows_of_the_filter() {
    let (depth, map) = (plane(48, [0.4, 0.3]), written(&plane(48, [0.1, 0.6])));
    for filter in ["kernel: 5", "kernel: 3, pattern: Disc"] {
        let hard = shadow(filter, &depth, &map);
        assert!(hard.pixels.iter().any(|pixel| pixel[0] > 0.0 && pixel[0] < 1.0), "{filter}: edges");
        for size in ["light_diameter: 0.0, blocker_taps: 64, largest: 1.0", "angular_diameter: 20.0"] {
            assert_eq!(shadow(&format!("{filter}, {size}"), &depth, &map), hard, "{filter}, {size}");
        }
        assert!(shadow(&format!("{filter}, light_diameter: 0.5"), &depth, &map) != hard, "a light of some size");
    }
}

/// Nothing before a place, and everything: no search is needed to say what the shares are.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_blocker_is_light_and_blockers_everywhere_are_shadow() {
    let depth = Picture::new(32, 32, |_, _| [3.0, 0.0, 0.0, 1.0]);
    for (map, share) in [(3.0, 0.0), (50.0, 0.0), (f32::INFINITY, 0.0), (2.9, 1.0), (0.1, 1.0)] {
        let map = Picture::new(32, 32, |_, _| [0.1 / map, 0.0, 0.0, 1.0]);
        for size in ["0.01", "0.5", "100.0"] {
            // What lies beyond the map blocks nothing, so the middle alone is in full shadow.
            let found = shadow(&format!("light_diameter: {size}, largest: 0.3"), &depth, &map);
            let middle = (12..20).flat_map(|y| (12..20).map(move |x| (x, y)));
            for (x, y) in middle {
                assert_eq!(found.at(x, y)[0], share, "a light of {size} m, {x}, {y}");
            }
        }
    }
}

/// What the map does not show is lit, and so is the sky.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_the_map_does_not_show_is_lit() {
    let near = Picture::new(16, 16, |_, _| [1.0, 0.0, 0.0, 1.0]);
    let sky = Picture::new(16, 16, |x, _| [if x < 8 { 65504.0 } else { 5.0 }, 0.0, 0.0, 1.0]);
    for parameters in ["kernel: 1", "kernel: 1, light_diameter: 0.5"] {
        let found = shadow(parameters, &sky, &near);
        assert!((0..8).all(|x| found.at(x, 3)[0] == 0.0) && (8..12).all(|x| found.at(x, 3)[0] == 1.0), "{parameters}");
    }
}

/// Depths and normals that are not finite, and maps of nothing: the shares are shares.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn broken_depths_and_maps_give_shares_from_0_to_1() {
    let odd = [f32::NAN, f32::INFINITY, -5.0, 0.0, 1e30, 65504.0, 1e-30, 2.0, 1.0];
    let data = Picture::new(24, 16, |x, y| [odd[((3 * x + 5 * y) % 9) as usize]; 4]);
    for parameters in [
        "kernel: 7",
        "pattern: Disc",
        "normal: \"depth\", normal_bias: 8.0",
        "slope_bias: 8.0, bias: 100.0",
        "light_diameter: 100.0, largest: 1.0, blocker_taps: 64, taps: 64",
        "light_diameter: 0.1, largest: 0.0, blocker_taps: 1, taps: 1, bias: 0.0",
        "light_diameter: 1.0, normal: \"depth\", normal_bias: 8.0, bias: 100.0",
    ] {
        let found = shadow(parameters, &data, &data);
        assert!(found.pixels.iter().all(|pixel| (0.0..=1.0).contains(&pixel[0])), "{parameters}");
    }
}

/// A fallback without a shadow: nothing is blocked, and the light is the source.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_amount_of_nothing_blocks_nothing() {
    let depth = plane(16, [0.2, 0.1]);
    let found = shadow("amount: 0.0", &depth, &depth);
    assert!(found.pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]));
}
