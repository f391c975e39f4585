//! The curve that kinds with points draw through them, as `nodes/folders/lib/monotone.wgsl` defines it.

/// The least distance of points in x.
const STEP: f64 = 1.0 / 1024.0;

/// The monotone cubic of Fritsch and Butland (1984) through points at `x`; straight beyond the ends. A point that is
/// not to the right of the one before is moved there.
///
/// # Panics
/// There are fewer than three points.
pub fn monotone(points: &[[f64; 2]], x: f64) -> f64 {
    let mut placed: Vec<[f64; 2]> = points.to_vec();
    for index in 1..placed.len() {
        placed[index][0] = placed[index][0].max(placed[index - 1][0] + STEP);
    }
    let last = placed.len() - 1;
    let slope = |index: usize| match index {
        0 => end_slope(placed[0], placed[1], placed[2]),
        end if end == last => end_slope(placed[last], placed[last - 1], placed[last - 2]),
        _ => inner_slope(placed[index - 1], placed[index], placed[index + 1]),
    };
    if x <= placed[0][0] {
        return placed[0][1] + slope(0) * (x - placed[0][0]);
    }
    let Some(end) = placed.iter().position(|point| x < point[0]) else {
        return placed[last][1] + slope(last) * (x - placed[last][0]);
    };
    let ([left, low], [right, high]) = (placed[end - 1], placed[end]);
    let (width, t) = (right - left, (x - left) / (right - left));
    let rest = 1.0 - t;
    let bend = rest * slope(end - 1) - t * slope(end);
    low * rest * rest * (1.0 + 2.0 * t) + high * t * t * (3.0 - 2.0 * t) + width * t * rest * bend
}

/// The harmonic mean of both secants, the nearer one weighted more; 0 where the points turn.
fn inner_slope(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (before, after) = (b[0] - a[0], c[0] - b[0]);
    let (left, right) = ((b[1] - a[1]) / before, (c[1] - b[1]) / after);
    if left * right <= 0.0 {
        return 0.0;
    }
    let sum = (2.0 * after + before) * right + (after + 2.0 * before) * left;
    3.0 * (before + after) * left * right / sum
}

/// That of the parabola through an end and the next two points, limited so that the cubic stays monotone.
fn end_slope(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (near, far) = (b[0] - a[0], c[0] - b[0]);
    let (left, right) = ((b[1] - a[1]) / near, (c[1] - b[1]) / far);
    let slope = ((2.0 * near + far) * left - near * right) / (near + far);
    match slope * left <= 0.0 {
        true => 0.0,
        false if left * right <= 0.0 && slope.abs() > (3.0 * left).abs() => 3.0 * left,
        false => slope,
    }
}
