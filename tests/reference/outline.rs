//! Lines where the inverse of the depth bends, or where normals turn.

use super::image::{Image, rgb};
use super::math::{Rgb, dot, mix, smooth_step};
use super::view::distance_of;

/// The strength of the line at a pixel by depth.
pub(crate) fn depth_edge(depth: &Image, [x, y]: [usize; 2], width: i64, threshold: f64) -> f64 {
    let inverse = |i: i64, j: i64| 1.0 / distance_of(depth.texel(x as i64 + i, y as i64 + j)[0]);
    let center = inverse(0, 0);
    let fold = |i: i64, j: i64| (inverse(-i, -j) + inverse(i, j) - 2.0 * center).abs() / center;
    smooth_step(threshold, 2.0 * threshold, fold(width, 0).max(fold(0, width)))
}

/// The strength of the line at a pixel by normals.
pub(crate) fn normal_edge(normal: &Image, [x, y]: [usize; 2], width: i64, threshold: f64) -> f64 {
    let unit = |i: i64, j: i64| {
        let v = rgb(normal.texel(x as i64 + i, y as i64 + j));
        v.map(|part| part / dot(v, v).sqrt().max(1e-3))
    };
    let turn = |i: i64, j: i64| 1.0 - dot(unit(-i, -j), unit(i, j));
    smooth_step(threshold, 2.0 * threshold, turn(width, 0).max(turn(0, width)))
}

/// The image with lines of that strength.
pub(crate) fn drawn(image: &Image, color: Rgb, edge: impl Fn([usize; 2]) -> f64) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let (source, edge) = (image.texel(x as i64, y as i64), edge([x, y]));
        let mixed = |c: usize| mix(source[c], color[c], edge);
        [mixed(0), mixed(1), mixed(2), mix(source[3], 1.0, edge)]
    })
}

#[test]
fn a_plane_has_no_lines_at_any_slope_and_a_step_has() {
    // The depth of a plane that is seen in perspective.
    let plane = Image::new(32, 32, |x, y| [1.0 / (0.02 + 0.004 * x as f64 + 0.03 * y as f64), 0.0, 0.0, 1.0]);
    assert!((1..31).all(|i| depth_edge(&plane, [i, 31 - i], 1, 1e-9) == 0.0));
    let step = Image::new(8, 8, |x, _| [if x < 4 { 2.0 } else { 3.0 }, 0.0, 0.0, 1.0]);
    assert!(depth_edge(&step, [4, 4], 1, 0.05) == 1.0 && depth_edge(&step, [6, 4], 1, 0.05) == 0.0);
}
