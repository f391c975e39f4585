//! The hulls of the display and of the source by hue, as the Academy's transform samples them: at 360 hues that include
//! the corners of both gamuts.

use glam::{DVec2, DVec3, dvec3};

use super::cam::{Jmh, Model, REFERENCE, direction};
use super::gamut::{GamutParams, Hull, SMOOTH_CUSPS, SMOOTH_M};

const HUES: usize = 360;

/// The corners of the unit cube from red over yellow to magenta.
const CORNERS: [DVec3; 6] = [
    dvec3(1.0, 0.0, 0.0),
    dvec3(1.0, 1.0, 0.0),
    dvec3(0.0, 1.0, 0.0),
    dvec3(0.0, 1.0, 1.0),
    dvec3(0.0, 0.0, 1.0),
    dvec3(1.0, 0.0, 1.0),
];

/// Hulls by hue, interpolated linearly.
#[derive(Clone, Debug)]
pub(super) struct Hulls {
    /// Hues in degrees from 0 up, and cusp J, cusp M and the inverse upper exponent there.
    display: Vec<(f64, [f64; 3])>,
    /// The reach at each degree.
    reach: Vec<f64>,
}

impl Hulls {
    /// `display` and `source` are the models of the display's and the source's primaries. `brightest` is the luminance
    /// up to which the source's corners are searched.
    pub(super) fn new(display: Model, source: Model, params: GamutParams, peak: f64, brightest: f64) -> Self {
        let reach = (0..HUES).map(|hue| reach_m(source, params.limit_j, hue as f64)).collect();
        let corners = corners(display, peak / REFERENCE);
        let mut hues: Vec<f64> = corners.iter().map(|(hue, _)| *hue).collect();
        hues.extend(source_corner_hues(source, params.limit_j, brightest));
        hues.sort_by(f64::total_cmp);
        hues.dedup();
        let cusp = |hue: f64| {
            let [j, m] = cusp_at(display, &corners, hue);
            let m = m * (1.0 + SMOOTH_M * SMOOTH_CUSPS);
            (hue, [j, m, upper_gamma_inv(display, params, peak, j, m, hue)])
        };
        Self { display: sampled_hues(&hues).into_iter().map(cusp).collect(), reach }
    }

    /// The hulls at a hue in degrees, 0 to 360.
    pub(super) fn at(&self, hue: f64) -> Hull {
        let next = self.display.partition_point(|(at, _)| *at < hue);
        let count = self.display.len();
        let (low, a) = if next == 0 { self.wrapped(count - 1, -360.0) } else { self.display[next - 1] };
        let (high, b) = if next == count { self.wrapped(0, 360.0) } else { self.display[next] };
        let share = (hue - low) / (high - low);
        let [cusp_j, cusp_m, upper_gamma_inv] = [0, 1, 2].map(|index| a[index] + share * (b[index] - a[index]));
        let base = hue.floor();
        let [below, above] = [base, base + 1.0].map(|degree| self.reach[degree as usize % HUES]);
        Hull { cusp_j, cusp_m, upper_gamma_inv, reach_m: below + (hue - base) * (above - below) }
    }

    fn wrapped(&self, index: usize, by: f64) -> (f64, [f64; 3]) {
        let (hue, values) = self.display[index];
        (hue + by, values)
    }
}

/// The corners of a display's gamut by hue, with their RGB.
fn corners(display: Model, peak: f64) -> Vec<(f64, DVec3)> {
    let mut all: Vec<(f64, DVec3)> =
        CORNERS.iter().map(|rgb| (display.to_jmh(*rgb * peak).degrees(), *rgb * peak)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// The hues of the source's corners where they have the J of the peak.
fn source_corner_hues(source: Model, limit_j: f64, brightest: f64) -> Vec<f64> {
    let target = source.achromatic(limit_j);
    let hue = |corner: &DVec3| {
        let (mut low, mut high) = (0.0, brightest);
        while high - low > 1e-3 {
            let middle = 0.5 * (low + high);
            if source.response(middle * *corner).x < target { low = middle } else { high = middle }
        }
        source.to_jmh(high * *corner).degrees()
    };
    CORNERS.iter().map(hue).collect()
}

/// 360 hues from 0 that include the given ones: each interval has equal steps of about one degree.
fn sampled_hues(corners: &[f64]) -> Vec<f64> {
    let mut counts: Vec<usize> = Vec::new();
    let mut least = if corners[0] == 0.0 { 0 } else { 1 };
    let mut last = usize::MAX;
    for (index, hue) in corners.iter().enumerate() {
        let mut nominal = (hue.round() as usize).clamp(least, HUES - 1);
        if last == nominal {
            // Two corners within a degree: the earlier one gets a sample less, if its interval has one to spare.
            if index > 1 && counts[index - 2] + 1 != counts[index - 1] {
                counts[index - 1] -= 1;
            } else {
                nominal += 1;
            }
        }
        counts.push(nominal.min(HUES - 1));
        (last, least) = (nominal, nominal);
    }
    let (mut hues, mut low, mut from) = (Vec::new(), 0.0, 0);
    for (high, to) in corners.iter().copied().zip(counts).chain([(360.0, HUES)]) {
        let samples = to - from;
        hues.extend((0..samples).map(|step| low + (high - low) * step as f64 / samples as f64));
        (low, from) = (high, to);
    }
    hues
}

/// The largest M of a source at a J and a hue: the first multiple of 50 outside of its gamut, then halvings to 0.01.
fn reach_m(source: Model, j: f64, hue: f64) -> f64 {
    let hue = direction(hue);
    let is_outside = |m: f64| source.to_rgb(Jmh { j, m, hue }).min_element() < 0.0;
    let (mut low, mut high) = (0.0, 50.0);
    while high < 1300.0 && !is_outside(high) {
        (low, high) = (high, high + 50.0);
    }
    while high - low > 1e-2 {
        let middle = 0.5 * (low + high);
        if is_outside(middle) { high = middle } else { low = middle }
    }
    high
}

/// J and M of the display's cusp at a hue: on the edge of the cube between the two corners around the hue.
fn cusp_at(display: Model, corners: &[(f64, DVec3)], hue: f64) -> [f64; 2] {
    let next = corners.partition_point(|(at, _)| *at <= hue);
    let count = corners.len();
    let (low_hue, from) =
        if next == 0 { (corners[count - 1].0 - 360.0, corners[count - 1].1) } else { corners[next - 1] };
    let to = corners[next % count].1;
    // Angles from the lower corner grow along the edge, also across 0 degrees.
    let target = hue - low_hue;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let found = (display.to_jmh(from.lerp(to, middle)).degrees() - low_hue).rem_euclid(360.0);
        // Just before the lower corner the angle is nearly 360.
        if found > target && found < 300.0 { high = middle } else { low = middle }
    }
    let cusp = display.to_jmh(from.lerp(to, 0.5 * (low + high)));
    [cusp.j, cusp.m]
}

/// The inverse exponent of the upper hull: the smallest exponent for which five points of the approximated hull are
/// outside of the display's gamut.
fn upper_gamma_inv(display: Model, params: GamutParams, peak: f64, cusp_j: f64, cusp_m: f64, hue: f64) -> f64 {
    let hue = direction(hue);
    let is_outside = |gamma: f64| {
        let hull = Hull { cusp_j, cusp_m, upper_gamma_inv: 1.0 / gamma, reach_m: 0.0 };
        [0.01, 0.1, 0.5, 0.8, 0.99].iter().all(|share| {
            let line = params.line(cusp_j + (params.limit_j - cusp_j) * share, cusp_m, &hull);
            let m = params.border(line, &hull);
            display.to_rgb(Jmh { j: line.start + line.slope * m, m, hue }).max_element() > peak / REFERENCE
        })
    };
    let (mut low, mut high) = (0.0, 0.4);
    while high < 5.0 && !is_outside(high) {
        (low, high) = (high, high + 0.4);
    }
    while high - low > 1e-5 {
        let middle = 0.5 * (low + high);
        if is_outside(middle) { high = middle } else { low = middle }
    }
    1.0 / high
}

/// The hulls over an interval of hues: at its begin, at a hue within it where they bend, and at its end. `bend` is the
/// place of this hue, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub values: [[f64; 4]; 3],
    pub bend: f64,
}

impl Hulls {
    /// Segments of equal length around the hues: along the border of a square around the origin, from the positive a
    /// axis to the positive b axis. This position grows with the angle and needs no trigonometry.
    pub(super) fn segments(&self, count: usize) -> Vec<Segment> {
        let degrees = (0..HUES).map(|degree| degree as f64);
        let mut bends: Vec<f64> = self
            .display
            .iter()
            .map(|(hue, _)| *hue)
            .chain(degrees)
            .map(|hue| square_position(direction(hue)))
            .collect();
        bends.sort_by(f64::total_cmp);
        let place = |index: usize| 4.0 * index as f64 / count as f64;
        (0..count).map(|index| self.segment(place(index), place(index + 1), &bends)).collect()
    }

    fn segment(&self, from: f64, to: f64, bends: &[f64]) -> Segment {
        let [first, last] = [from, to].map(|place| self.values(place));
        let inside = &bends[bends.partition_point(|place| *place <= from)..];
        // How far the hulls are from a straight line.
        let distance = |place: f64| {
            let (share, values) = ((place - from) / (to - from), self.values(place));
            let off = |index: usize| values[index] - first[index] - share * (last[index] - first[index]);
            [0, 1, 2, 3].map(|index| (off(index) / values[index]).abs()).iter().sum::<f64>()
        };
        let inside = inside.iter().copied().take_while(|place| *place < to - 1e-9);
        let bend = inside.max_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(0.5 * (from + to));
        let share = ((bend - from) / (to - from)).clamp(1e-4, 1.0 - 1e-4);
        Segment { values: [first, self.values(bend), last], bend: share }
    }

    fn values(&self, position: f64) -> [f64; 4] {
        let hue = from_square_position(position.rem_euclid(4.0));
        let hull = self.at(Jmh { j: 0.0, m: 0.0, hue }.degrees());
        [hull.cusp_j, hull.cusp_m, hull.upper_gamma_inv, hull.reach_m]
    }
}

/// The position of a hue on the border of a square around the origin, 0 to 4.
fn square_position(hue: DVec2) -> f64 {
    let x = hue.x / (hue.x.abs() + hue.y.abs());
    if hue.y >= 0.0 { 1.0 - x } else { 3.0 + x }
}

/// The hue at such a position.
fn from_square_position(position: f64) -> DVec2 {
    let x = if position <= 2.0 { 1.0 - position } else { position - 3.0 };
    let y = 1.0 - x.abs();
    DVec2::new(x, if position <= 2.0 { y } else { -y }).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_of_hues_are_inverse_and_grow() {
        let mut last = -1.0;
        for step in 0..720 {
            let hue = direction(0.5 * f64::from(step));
            let position = square_position(hue);
            assert!(position > last && position < 4.0, "{step}: {position} after {last}");
            assert!((from_square_position(position) - hue).length() < 1e-12, "{step}");
            last = position;
        }
    }

    #[test]
    fn sampled_hues_include_the_corners() {
        let corners = [20.3, 20.9, 90.0, 141.2, 194.6, 194.7, 283.1, 322.9];
        let hues = sampled_hues(&corners);
        assert_eq!(hues.len(), HUES);
        assert!(hues.is_sorted() && corners.iter().all(|corner| hues.contains(corner)), "{hues:?}");
        assert!(hues.windows(2).all(|pair| pair[1] - pair[0] < 2.0), "{hues:?}");
    }
}
