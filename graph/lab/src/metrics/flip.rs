//! FLIP: the difference that a viewer sees when two pictures alternate.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: a difference evaluator for alternating
//! images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3 (2020); for HDR, Andersson,
//! Nilsson, Shirley and Akenine-Möller, "Visualizing errors in rendered high dynamic range images", Eurographics
//! 2021.

use std::f64::consts::PI;

use afterimage_graph::color::LUMINANCE_REC709;
use glam::DVec3;
use rayon::prelude::*;

use super::color::{XYZ, lab, srgb_decode, white};
use super::plane::{Plane, gaussian, offsets};
use super::{Range, Shown};

/// Pixels in a degree of view that FLIP takes by default: a screen of 3840 pixels and 0.7 m width, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Exponent of the color difference.
const COLOR_EXPONENT: f64 = 0.7;
/// The share of the largest color difference that is mapped to `KNEE_VALUE`.
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the lines and points that features are, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// The error that is seen at each pixel, 0 to 1; its mean is the figure that FLIP gives for a pair.
///
/// An HDR pair is compared at a series of exposures that the reference sets, and the greatest error counts.
pub fn flip(reference: &Shown, other: &Shown, pixels_per_degree: f64) -> Vec<f32> {
    let at = |shown: &Shown, decode: &(dyn Fn(f64) -> f64 + Sync)| Seen::new(shown, pixels_per_degree, decode);
    match reference.range {
        Range::Sdr => at(reference, &srgb_decode).difference(&at(other, &srgb_decode)),
        Range::Hdr => {
            let mut worst = vec![0.0_f32; reference.pixels.len()];
            for stops in exposures(reference) {
                let shown = |x: f64| film(x * stops.exp2());
                let error = at(reference, &shown).difference(&at(other, &shown));
                worst.iter_mut().zip(error).for_each(|(worst, error)| *worst = worst.max(error));
            }
            worst
        }
    }
}

/// A picture as seen: colors blurred by the eye, and the edges and points of its brightness.
struct Seen {
    colors: Vec<[f64; 3]>,
    features: Vec<[f32; 2]>,
}

impl Seen {
    fn new(shown: &Shown, pixels_per_degree: f64, decode: &(dyn Fn(f64) -> f64 + Sync)) -> Self {
        let linear: Vec<DVec3> = shown
            .pixels
            .par_iter()
            .map(|p| DVec3::from_array(p.map(|x| decode(f64::from(x)).clamp(0.0, 1.0))))
            .collect();
        let opponent: Vec<[f32; 3]> = linear.par_iter().map(|rgb| opponent(XYZ * *rgb).map(|x| x as f32)).collect();
        let plane = |c: usize| Plane::new(shown.width, opponent.iter().map(|pixel| pixel[c]).collect());
        let planes = [plane(0), plane(1), plane(2)];
        Self { colors: blurred(&planes, pixels_per_degree), features: features(&planes[0], pixels_per_degree) }
    }

    fn difference(&self, other: &Self) -> Vec<f32> {
        let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| hunt(lab(XYZ * rgb)));
        let largest = distance(green, blue).powf(COLOR_EXPONENT);
        let pixels = (0..self.colors.len()).into_par_iter().map(|at| {
            let color = color_difference(self.colors[at], other.colors[at], largest);
            let feature = feature_difference(self.features[at], other.features[at]);
            color.powf(1.0 - feature) as f32
        });
        pixels.collect()
    }
}

/// Brightness, red against green, blue against yellow: CIELAB without its cube root, so that blurring it makes sense.
fn opponent(xyz: DVec3) -> [f64; 3] {
    let [x, y, z] = (xyz / white()).to_array();
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn xyz_of_opponent([y, cx, cz]: [f64; 3]) -> DVec3 {
    let y = (y + 16.0) / 116.0;
    DVec3::new(y + cx / 500.0, y, y - cz / 200.0) * white()
}

/// A sensitivity of the eye to contrast is a sum of Gaussians: strength and inverse width of each, in degrees.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
const WIDEST: f64 = 0.04;

/// The opponent planes blurred as the eye does, in CIELAB adjusted for the Hunt effect.
fn blurred(planes: &[Plane; 3], pixels_per_degree: f64) -> Vec<[f64; 3]> {
    let [y, cx, cz] = [0, 1, 2].map(|c| filtered(&planes[c], SENSITIVITY[c], pixels_per_degree));
    let to_rgb = XYZ.inverse();
    let colors = (0..y.len()).into_par_iter().map(|at| {
        // Brought back to what a screen can show.
        let xyz = xyz_of_opponent([y[at], cx[at], cz[at]].map(f64::from));
        hunt(lab(XYZ * (to_rgb * xyz).clamp(DVec3::ZERO, DVec3::ONE)))
    });
    colors.collect()
}

/// A plane after a weighted sum of Gaussians, whose weights are their masses.
fn filtered(plane: &Plane, gaussians: &[(f64, f64)], pixels_per_degree: f64) -> Vec<f32> {
    let deviation = |width: f64| (width / (2.0 * PI * PI)).sqrt() * pixels_per_degree;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let mut masses = Vec::new();
    for (strength, width) in gaussians {
        let sum: f64 = offsets(radius).map(|x| (-(x / deviation(*width)).powi(2) / 2.0).exp()).sum();
        masses.push(strength * (PI / width).sqrt() * sum * sum);
    }
    let all: f64 = masses.iter().sum();
    let mut result = vec![0.0; plane.data.len()];
    for ((_, width), mass) in gaussians.iter().zip(&masses) {
        let kernel = gaussian(deviation(*width), radius);
        let share = (mass / all) as f32;
        let part = plane.convolved(&kernel, &kernel).data;
        result.iter_mut().zip(part).for_each(|(to, part)| *to += share * part);
    }
    result
}

/// Colors look more vivid where it is brighter.
fn hunt([l, a, b]: [f64; 3]) -> [f64; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The HyAB distance.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// `largest` is the difference between full green and full blue.
fn color_difference(a: [f64; 3], b: [f64; 3], largest: f64) -> f64 {
    let difference = distance(a, b).powf(COLOR_EXPONENT);
    let knee = KNEE * largest;
    if difference < knee {
        return KNEE_VALUE / knee * difference;
    }
    KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
}

/// The strength of the edge and of the point at each pixel.
fn features(brightness: &Plane, pixels_per_degree: f64) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let bell = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let smooth = gaussian(deviation, radius);
    let edge = balanced(offsets(radius).map(|x| -x * bell(x)).collect());
    let point = balanced(offsets(radius).map(|x| ((x / deviation).powi(2) - 1.0) * bell(x)).collect());
    let unit = Plane::new(brightness.width, brightness.data.iter().map(|y| (y + 16.0) / 116.0).collect());
    let strength = |kernel: &[f32]| -> Vec<f32> {
        let (across, down) = (unit.convolved(kernel, &smooth).data, unit.convolved(&smooth, kernel).data);
        across.iter().zip(down).map(|(x, y)| x.hypot(y)).collect()
    };
    strength(&edge).into_iter().zip(strength(&point)).map(|(edge, point)| [edge, point]).collect()
}

/// Scales positive weights to a sum of 1 and negative ones to a sum of -1.
fn balanced(weights: Vec<f64>) -> Vec<f32> {
    let sum = |sign: f64| weights.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    weights.iter().map(|w| (if *w > 0.0 { w / positive } else { w / negative }) as f32).collect()
}

fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f64 {
    let largest = f64::from((a[0] - b[0]).abs().max((a[1] - b[1]).abs()));
    (largest / 2.0_f64.sqrt()).powf(FEATURE_EXPONENT)
}

/// The tone curve of HDR-FLIP: Narkowicz's fit of the ACES curve, for 0.6 times the luminance.
const FILM: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn film(x: f64) -> f64 {
    (FILM[0] * x * x + FILM[1] * x + FILM[2]) / (FILM[3] * x * x + FILM[4] * x + FILM[5])
}

/// Stops between the exposure at which the brightest pixel of the reference, and that at which its median, come out at
/// 0.85.
fn exposures(reference: &Shown) -> Vec<f64> {
    let mut luminance: Vec<f64> =
        reference.pixels.iter().map(|pixel| DVec3::from(pixel.map(f64::from)).dot(LUMINANCE_REC709.into())).collect();
    luminance.sort_by(f64::total_cmp);
    let middle = luminance.len() / 2;
    let median =
        if luminance.len() % 2 == 1 { luminance[middle] } else { (luminance[middle - 1] + luminance[middle]) / 2.0 };
    let brightest = luminance[luminance.len() - 1];
    if brightest <= 0.0 {
        return vec![0.0];
    }
    let [a, b, c] = [0, 1, 2].map(|i| FILM[i] - 0.85 * FILM[i + 3]);
    let luminance = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let start = (luminance / brightest).log2();
    let stop = (luminance / median.max(f64::from(f32::EPSILON))).log2();
    let count = (stop - start).ceil().max(2.0) as usize;
    (0..count).map(|i| start + (stop - start) * i as f64 / (count - 1) as f64).collect()
}
