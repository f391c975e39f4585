//! Color spaces, chromatic adaptation and white balance.
//!
//! Matrices from primaries: SMPTE RP 177. Daylight locus: CIE 15. Planckian locus: the cubic fit
//! of Kim et al. (2002). Bradford: Lam (1985). CAT16: Li et al. (2017).

use super::math::{Matrix, Rgb, diagonal, dot, inverse, mix, product, transform, transpose, zip};

/// The relative luminance of linear Rec.709, with the usual four-digit weights.
pub(crate) fn luminance(rgb: Rgb) -> f64 {
    dot(rgb, [0.2126, 0.7152, 0.0722])
}

/// Luminance of the channels above 0.
pub(crate) fn level_luminance(rgb: Rgb) -> f64 {
    luminance(rgb.map(|x| if x < 0.0 { 0.0 } else { x }))
}

/// The CIE xy chromaticities of a space's three primaries and its white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    pub(crate) red: [f64; 2],
    pub(crate) green: [f64; 2],
    pub(crate) blue: [f64; 2],
    pub(crate) white: [f64; 2],
}

/// The white of sRGB, Rec.709, P3-D65 and Rec.2020.
pub(crate) const D65: [f64; 2] = [0.3127, 0.3290];

/// The white of the ACES spaces, close to D60.
pub(crate) const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];

/// ITU-R BT.709.
pub(crate) const REC709: Space = Space { red: [0.640, 0.330], green: [0.300, 0.600], blue: [0.150, 0.060], white: D65 };

/// SMPTE EG 432-1 with the white of D65.
pub(crate) const P3_D65: Space = Space { red: [0.680, 0.320], green: [0.265, 0.690], blue: [0.150, 0.060], white: D65 };

/// ITU-R BT.2020.
pub(crate) const REC2020: Space =
    Space { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], white: D65 };

/// The primaries AP1 of ACES.
pub(crate) const AP1: Space =
    Space { red: [0.713, 0.293], green: [0.165, 0.830], blue: [0.128, 0.044], white: ACES_WHITE };

/// AP1 with the red primary pushed outwards: the working space of the formula book, section 2.
pub(crate) const CUSTOM: Space = Space { red: [0.750, 0.270], ..AP1 };

/// The cone responses of the Bradford transform.
pub(crate) const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The cone responses of CAT16.
pub(crate) const CAT16: Matrix =
    [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]];

/// The XYZ of a chromaticity at luminance 1.
pub(crate) fn xyz([x, y]: [f64; 2]) -> Rgb {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// `P · diag(P⁻¹ · W)`: linear RGB of `space` to XYZ, its white at Y = 1.
pub(crate) fn to_xyz(space: &Space) -> Matrix {
    let primaries = transpose(&[space.red, space.green, space.blue].map(|[x, y]| [x, y, 1.0 - x - y]));
    let strengths = transform(&inverse(&primaries), xyz(space.white));
    product(&primaries, &diagonal(strengths))
}

/// XYZ to linear RGB of `space`.
pub(crate) fn from_xyz(space: &Space) -> Matrix {
    inverse(&to_xyz(space))
}

/// The von Kries adaptation, in the cone space `cone`, that takes one XYZ white to another.
pub(crate) fn adaptation(cone: &Matrix, source: Rgb, destination: Rgb) -> Matrix {
    let gains = zip(transform(cone, destination), transform(cone, source), |to, from| to / from);
    product(&inverse(cone), &product(&diagonal(gains), cone))
}

/// Linear RGB of one space to another, whites matched by Bradford.
pub(crate) fn conversion(source: &Space, destination: &Space) -> Matrix {
    let adapt = adaptation(&BRADFORD, xyz(source.white), xyz(destination.white));
    product(&from_xyz(destination), &product(&adapt, &to_xyz(source)))
}

/// An XYZ matrix as seen from linear Rec.709.
fn in_rec709(matrix: &Matrix) -> Matrix {
    product(&from_xyz(&REC709), &product(matrix, &to_xyz(&REC709)))
}

/// The Rec.709 matrix that turns white into `wanted` (formula book, 6: target mode). Components
/// below 1e-4 are raised to it; `normalize` scales `wanted` to Y = 1 in XYZ first, because rounded
/// luminance weights would brighten the image by some millionths.
pub(crate) fn white_balance_target(cone: &Matrix, wanted: Rgb, normalize: bool) -> Matrix {
    let wanted = transform(&to_xyz(&REC709), wanted.map(|x| x.max(1e-4)));
    let scale = if normalize { 1.0 / wanted[1] } else { 1.0 };
    in_rec709(&adaptation(cone, xyz(D65), wanted.map(|x| x * scale)))
}

/// The Rec.709 matrix that turns a scene white of `kelvin` and `duv` into neutral D65 (formula
/// book, 6: scene-white mode). Positive `duv` says that the scene's light is greenish.
pub(crate) fn white_balance_scene(cone: &Matrix, kelvin: f64, duv: f64) -> Matrix {
    in_rec709(&adaptation(cone, xyz(scene_white(kelvin, duv)), xyz(D65)))
}

/// The xy of a light: a black body up to 3333 K, daylight from 4000 K, a blend between; `kelvin` clamps to 1667..25000.
/// `duv` moves it along the normal of the locus in CIE 1960 uv, positive toward green.
pub(crate) fn scene_white(kelvin: f64, duv: f64) -> [f64; 2] {
    let kelvin = kelvin.clamp(1667.0, 25000.0);
    let (body, day) = (planck(kelvin), daylight(kelvin));
    let (p, q) = (body.at(kelvin), day.at(kelvin));
    let (dp, dq) = (body.cooler(kelvin), day.cooler(kelvin));
    // The share of daylight, and its derivative toward cooler light in units of 1000 / K.
    let t = ((300.0 - 1e6 / kelvin) / 50.0).clamp(0.0, 1.0);
    let (share, rise) = (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) * 20.0);
    let xy = [0, 1].map(|i| mix(p[i], q[i], share));
    let cooler = [0, 1].map(|i| mix(dp[i], dq[i], share) + rise * (q[i] - p[i]));
    beside(xy, cooler, duv)
}

/// The xy of CIE daylight, 4000 K to 25000 K.
pub(crate) fn daylight_xy(kelvin: f64) -> [f64; 2] {
    daylight(kelvin).at(kelvin)
}

/// The xy of a black body, 1667 K to 25000 K.
pub(crate) fn planck_xy(kelvin: f64) -> [f64; 2] {
    planck(kelvin).at(kelvin)
}

/// A stretch of a locus: x as a cubic in 1000 K / T, y as a cubic in x; highest power first.
struct Locus {
    x: [f64; 4],
    y: [f64; 4],
}

fn daylight(kelvin: f64) -> Locus {
    let x = if kelvin <= 7000.0 { [-4.6070, 2.9678, 0.09911, 0.244063] } else { [-2.0064, 1.9018, 0.24748, 0.237040] };
    Locus { x, y: [0.0, -3.0, 2.870, -0.275] }
}

fn planck(kelvin: f64) -> Locus {
    let x = if kelvin <= 4000.0 {
        [-0.2661239, -0.2343589, 0.8776956, 0.179910]
    } else {
        [-3.0258469, 2.1070379, 0.2226347, 0.240390]
    };
    let y = if kelvin <= 2222.0 {
        [-1.1063814, -1.34811020, 2.18555832, -0.20219683]
    } else if kelvin <= 4000.0 {
        [-0.9549476, -1.37418593, 2.09137015, -0.16748867]
    } else {
        [3.0817580, -5.87338670, 3.75112997, -0.37001483]
    };
    Locus { x, y }
}

impl Locus {
    fn at(&self, kelvin: f64) -> [f64; 2] {
        let x = cubic(self.x, 1000.0 / kelvin);
        [x, cubic(self.y, x)]
    }

    /// The direction in xy in which the light becomes cooler.
    fn cooler(&self, kelvin: f64) -> [f64; 2] {
        let dx = -slope(self.x, 1000.0 / kelvin);
        [dx, dx * slope(self.y, self.at(kelvin)[0])]
    }
}

/// The xy at distance `duv` in uv from a point of a locus, where the light becomes cooler in the given direction.
fn beside([x, y]: [f64; 2], [dx, dy]: [f64; 2], duv: f64) -> [f64; 2] {
    let [u, v] = uv_1960([x, y]);
    let w = -2.0 * x + 12.0 * y + 3.0;
    let dw = -2.0 * dx + 12.0 * dy;
    let (du, dv) = ((4.0 * dx - u * dw) / w, (6.0 * dy - v * dw) / w);
    let length = du.hypot(dv);
    xy_from_1960([u + duv * dv / length, v - duv * du / length])
}

fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    ((a * t + b) * t + c) * t + d
}

fn slope([a, b, c, _]: [f64; 4], t: f64) -> f64 {
    (3.0 * a * t + 2.0 * b) * t + c
}

fn uv_1960([x, y]: [f64; 2]) -> [f64; 2] {
    let w = -2.0 * x + 12.0 * y + 3.0;
    [4.0 * x / w, 6.0 * y / w]
}

fn xy_from_1960([u, v]: [f64; 2]) -> [f64; 2] {
    let w = 2.0 * u - 8.0 * v + 4.0;
    [3.0 * u / w, 2.0 * v / w]
}

#[test]
fn tint_moves_by_its_own_length_away_from_the_locus_toward_green() {
    for kelvin in [1800.0, 3200.0, 3600.0, 5000.0, 7000.0, 12000.0] {
        let on = uv_1960(scene_white(kelvin, 0.0));
        let beside = scene_white(kelvin, 0.015);
        let moved = uv_1960(beside);
        let distance = (moved[0] - on[0]).hypot(moved[1] - on[1]);
        assert!((distance - 0.015).abs() < 1e-12, "{kelvin} K moved by {distance}");
        assert!(moved[1] > on[1], "{kelvin} K moved toward magenta");
        // Every other point of the locus is farther away than the foot of the normal.
        for near in [kelvin * 0.97, kelvin * 1.03] {
            let other = uv_1960(scene_white(near, 0.0));
            assert!((moved[0] - other[0]).hypot(moved[1] - other[1]) > 0.015, "{kelvin} K");
        }
    }
}

#[test]
fn correcting_a_greenish_light_makes_white_magenta() {
    for cone in [BRADFORD, CAT16] {
        let [r, g, b] = transform(&white_balance_scene(&cone, 5500.0, 0.01), [1.0; 3]);
        let [r0, g0, b0] = transform(&white_balance_scene(&cone, 5500.0, 0.0), [1.0; 3]);
        assert!(r / g > r0 / g0 && b / g > b0 / g0);
    }
}

#[test]
fn a_target_is_what_white_becomes() {
    for cone in [BRADFORD, CAT16] {
        let wanted = [0.9, 1.3, 0.4];
        let white = transform(&white_balance_target(&cone, wanted, false), [1.0; 3]);
        let scaled = transform(&white_balance_target(&cone, wanted, true), [1.0; 3]);
        for channel in 0..3 {
            assert!((white[channel] - wanted[channel]).abs() < 2e-4, "{white:?}");
            let unit = wanted[channel] / luminance(wanted);
            assert!((scaled[channel] - unit).abs() < 2e-4, "{scaled:?}");
        }
    }
}
