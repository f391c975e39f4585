//! The hulls of the display and of the source by hue, as the Academy's transform samples them: at 360 hues that include
//! the corners of both gamuts.

use glam::{DVec2, DVec3, dvec3};

use super::cam::{Jmh, Model, REFERENCE, direction};
use super::gamut::{GamutParams, SMOOTH_CUSPS, SMOOTH_M};

/// Hues of the tables.
const HUES: usize = 360;

/// The hulls at one hue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    /// The cusp of the display: the brightest of the most colourful colours.
    pub(super) cusp_j: f64,
    pub(super) cusp_m: f64,
    /// The inverse exponent of the upper hull of the display.
    pub(super) upper_gamma_inv: f64,
    /// The largest M of the source at the peak's J.
    pub(super) reach_m: f64,
}

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
    /// `display` and `source` are the models of the display's and the source's primaries. `brightest` is the light up
    /// to which the source's corners are searched.
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
    let wanted = source.achromatic(limit_j);
    let hue = |corner: &DVec3| {
        let (mut low, mut high) = (0.0, brightest);
        while high - low > 1e-3 {
            let middle = 0.5 * (low + high);
            if source.response(middle * *corner).x < wanted { low = middle } else { high = middle }
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
    let wanted = hue - low_hue;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let found = (display.to_jmh(from.lerp(to, middle)).degrees() - low_hue).rem_euclid(360.0);
        // Just before the lower corner the angle is nearly 360.
        if found > wanted && found < 300.0 { high = middle } else { low = middle }
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

/// The hue at a position on the border of a square around the origin, 0 to 4: a monotonic stand-in for the angle that
/// needs no trigonometry to find.
pub(super) fn from_square_position(position: f64) -> DVec2 {
    let x = if position <= 2.0 { 1.0 - position } else { position - 3.0 };
    let y = 1.0 - x.abs();
    DVec2::new(x, if position <= 2.0 { y } else { -y }).normalize()
}
