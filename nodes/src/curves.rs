//! The tone curves in double precision, with the parameters of `ToneMap`: what they do to middle gray.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, dvec3};

use crate::tone_map::{AgxLook, Curve, MiddleGray, Sigmoid, ToneMap};
use afterimage_color::adaptation::LUMINANCE;
use afterimage_color::bisection::bisected;
use afterimage_color::curve_constants::{Agx, GT7_WHITE, Gt7, Shoulder};
use afterimage_color::process::transfer::{pq_decode, pq_encode};

impl ToneMap {
    /// The factor of exposed light before the curve.
    pub(crate) fn light_scale(&self) -> f64 {
        match self.middle_gray {
            MiddleGray::Native => 1.0,
            MiddleGray::Matched if self.curve == Curve::None => 1.0,
            MiddleGray::Matched => {
                // A look and the polynomial keep the exposure of the curve that they belong to.
                let plain = Self { look: AgxLook::Base, sigmoid: Sigmoid::Exact, ..self.clone() };
                bisected(MIN_SCALE, 1.0 / MIN_SCALE, |scale| plain.gray(scale) < MIDDLE_GRAY)
            }
        }
    }

    /// The output of a curve for middle gray, if its input is scaled.
    fn gray(&self, scale: f64) -> f64 {
        self.bend(DVec3::splat(scale * MIDDLE_GRAY), scale).y
    }

    /// The curve alone, in its working space, on light that was scaled by `scale`.
    fn bend(&self, v: DVec3, scale: f64) -> DVec3 {
        let white = (scale * f64::from(self.white_level)).powi(2);
        match self.curve {
            Curve::None => v,
            Curve::Reinhard => each(v, |x| x / (1.0 + x)),
            Curve::ReinhardExtended => each(v, |x| x * (1.0 + x / white) / (1.0 + x)),
            Curve::ReinhardLuminance => {
                let y = LUMINANCE.dot(v);
                v * ((1.0 + y / white) / (1.0 + y))
            }
            Curve::Exponential => each(v, |x| -(-f64::from(self.exposure) * x).exp_m1()),
            Curve::Aces2ToneScale => each(v, |x| self.aces2().apply(x)),
            Curve::AcesNarkowicz => each(v, |x| (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)),
            Curve::AcesHill => {
                each(v, |x| (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081))
            }
            Curve::Hable => each(v, |x| (hable(2.0 * x) / hable(11.2)).min(1.0)),
            Curve::Uchimura => each(v, |x| self.uchimura(x)),
            Curve::KhronosNeutral => khronos_neutral(v),
            Curve::AgX if self.is_agx_hdr() => each(v, |x| self.agx_hdr().apply(x)),
            Curve::AgX => self.agx_bend(v),
            Curve::Gt7 => self.gt7_bend(v),
        }
    }

    fn uchimura(&self, x: f64) -> f64 {
        let Shoulder { line_from: m, from, limit, gap, steepness } = self.shoulder();
        if x >= from {
            return (limit - gap * (-steepness * (x - from)).exp()).max(0.0);
        }
        let toe = m * (x.min(m) / m).powf(f64::from(self.toe)) + f64::from(self.pedestal);
        let line = m + f64::from(self.contrast) * (x - m);
        let share = smooth_step(0.0, m, x);
        (toe + (line - toe) * share).max(0.0)
    }

    fn agx_bend(&self, v: DVec3) -> DVec3 {
        let (low, high) = (0.18_f64.log2() - 10.0, 0.18_f64.log2() + 6.5);
        let curve = if self.sigmoid == Sigmoid::Exact { agx_sigmoid } else { agx_polynomial };
        let bent = each(AGX_INSET * v, |x| curve(((x.max(1e-10).log2() - low) / (high - low)).clamp(0.0, 1.0)));
        let looked = if self.look == AgxLook::Base { bent } else { agx_look(bent, self.agx()) };
        each(AGX_INSET_INVERSE.mul_vec3(looked), |x| x.clamp(0.0, 1.0).powf(2.2))
    }

    fn gt7_bend(&self, v: DVec3) -> DVec3 {
        let gt7 = self.gt7();
        let skewed = each(v, |x| gt7_channel(x, gt7));
        let own = to_ictcp(v);
        let fade = 1.0 - smooth_step(0.98, 1.16, own.x / gt7.intensity);
        let kept = from_ictcp(dvec3(to_ictcp(skewed).x, own.y * fade, own.z * fade));
        skewed.lerp(kept, 0.6).min(DVec3::splat(gt7.peak)) / GT7_WHITE
    }
}

/// Exposed middle gray, and the display-linear value that it becomes.
const MIDDLE_GRAY: f64 = 0.18;

/// The smallest factor of light that matches a curve to middle gray; its inverse is the largest.
const MIN_SCALE: f64 = 1.0 / 16.0;

fn each(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    dvec3(f(v.x), f(v.y), f(v.z))
}

fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn hable(x: f64) -> f64 {
    x * (0.14 * x + 0.05 / 3.0) / (x * (0.15 * x + 0.5) + 0.06)
}

fn khronos_neutral(v: DVec3) -> DVec3 {
    let least = v.min_element();
    let c = v - if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let peak = c.max_element();
    if peak < 0.76 {
        return c;
    }
    let pressed = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    let gray = 1.0 - 1.0 / (0.15 * (peak - pressed) + 1.0);
    (c * (pressed / peak)).lerp(DVec3::splat(pressed), gray)
}

const AGX_INSET: DMat3 = DMat3::from_cols(
    dvec3(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
    dvec3(0.0784335999999992, 0.878468636469772, 0.0784336),
    dvec3(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
);

static AGX_INSET_INVERSE: LazyLock<DMat3> = LazyLock::new(|| AGX_INSET.inverse());

/// Sobotka's sigmoid on normalized log2: slope 2 at (10/16.5, 0.5), toe of power 3, shoulder of power 3.25.
fn agx_sigmoid(t: f64) -> f64 {
    let pivot = 10.0 / 16.5;
    if t < pivot { 0.5 - agx_arm(pivot - t, pivot, 3.0) } else { 0.5 + agx_arm(t - pivot, 1.0 - pivot, 3.25) }
}

/// The rise at distance `reach` of an arm of the sigmoid that rises by 0.5 over `run`.
fn agx_arm(reach: f64, run: f64, exponent: f64) -> f64 {
    let scale = (((4.0 * run).powf(exponent) - 1.0) / (2.0 * run).powf(exponent)).powf(-1.0 / exponent);
    let u = 2.0 * reach / scale;
    scale * u / (1.0 + u.powf(exponent)).powf(1.0 / exponent)
}

fn agx_polynomial(t: f64) -> f64 {
    t * (0.124105529 + t * (0.207851246 + t * (-5.92929872 + t * (30.3767436 + t * (-38.901444 + t * 15.1220424)))))
}

fn agx_look(v: DVec3, look: Agx) -> DVec3 {
    let powered = each(v * look.slope, |x| x.max(0.0).powf(look.power));
    DVec3::splat(LUMINANCE.dot(powered)).lerp(powered, look.saturation)
}

fn gt7_channel(x: f64, gt7: Gt7) -> f64 {
    if x >= 0.444 * gt7.peak {
        return gt7.offset + gt7.scale * (gt7.rate * x).exp();
    }
    let toe = 0.538 * (x.min(0.538) / 0.538).powf(1.28);
    toe + (x - toe) * smooth_step(0.0, 0.538, x)
}

const LMS_FROM_REC2020: DMat3 = DMat3::from_cols(
    dvec3(1688.0 / 4096.0, 683.0 / 4096.0, 99.0 / 4096.0),
    dvec3(2146.0 / 4096.0, 2951.0 / 4096.0, 309.0 / 4096.0),
    dvec3(262.0 / 4096.0, 462.0 / 4096.0, 3688.0 / 4096.0),
);

const ICTCP_FROM_LMS: DMat3 = DMat3::from_cols(
    dvec3(2048.0 / 4096.0, 6610.0 / 4096.0, 17933.0 / 4096.0),
    dvec3(2048.0 / 4096.0, -13613.0 / 4096.0, -17390.0 / 4096.0),
    dvec3(0.0, 7003.0 / 4096.0, -543.0 / 4096.0),
);

static REC2020_FROM_LMS: LazyLock<DMat3> = LazyLock::new(|| LMS_FROM_REC2020.inverse());

static LMS_FROM_ICTCP: LazyLock<DMat3> = LazyLock::new(|| ICTCP_FROM_LMS.inverse());

fn to_ictcp(v: DVec3) -> DVec3 {
    ICTCP_FROM_LMS * each(LMS_FROM_REC2020 * v, |x| pq_encode(100.0 * x))
}

fn from_ictcp(v: DVec3) -> DVec3 {
    let lms = each(LMS_FROM_ICTCP.mul_vec3(v), |x| pq_decode(x.min(1.0)) / 100.0);
    REC2020_FROM_LMS.mul_vec3(lms).max(DVec3::ZERO)
}
