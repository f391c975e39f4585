//! Tone curves of `exposed` light, and the wrapper that runs one in another color space.
//!
//! Curves that work on one channel take and give an f64; curves that mix channels an [`Rgb`].
//! None is clamped to [0, 1] unless its definition is: [`display`] does that at the end.

use super::color::{REC709, Space, conversion, luminance};
use super::math::{Matrix, Rgb, largest, mix, smooth_step, transform};

/// Clamps to what a display-linear image holds.
pub(crate) fn display(rgb: Rgb) -> Rgb {
    rgb.map(|x| x.clamp(0.0, 1.0))
}

/// `x / (1 + x)` (Reinhard et al. 2002, equation 3).
pub(crate) fn reinhard(x: f64) -> f64 {
    x / (1.0 + x)
}

/// Reinhard's curve that reaches 1 at `white` and exceeds it above (2002, equation 4).
pub(crate) fn reinhard_extended(x: f64, white: f64) -> f64 {
    x * (1.0 + x / (white * white)) / (1.0 + x)
}

/// The same by luminance, so hue is kept; written without a division by luminance.
pub(crate) fn reinhard_luminance(rgb: Rgb, white: f64) -> Rgb {
    let y = luminance(rgb);
    rgb.map(|x| x * (1.0 + y / (white * white)) / (1.0 + y))
}

/// `1 − exp(−exposure · x)`, the response of film in the simplest model.
pub(crate) fn exponential(x: f64, exposure: f64) -> f64 {
    1.0 - (-exposure * x.max(0.0)).exp()
}

/// The tone scale of ACES 2.0 for a display with a peak of `n` cd/m2, with the names of the Academy's
/// `init_TonescaleParams` and `tonescale_fwd`. The result is in units of 100 cd/m2.
pub(crate) fn aces2_tone_scale(x: f64, n: f64) -> f64 {
    let (n_r, g, c, c_d, w_g, t_1) = (100.0, 1.15, 0.18, 10.013, 0.14, 0.04);
    let (r_hit_min, r_hit_max) = (128.0, 896.0);
    let r_hit = r_hit_min + (r_hit_max - r_hit_min) * ((n / n_r).ln() / (10000.0_f64 / 100.0).ln());
    let m_0 = n / n_r;
    let m_1 = 0.5 * (m_0 + (m_0 * (m_0 + 4.0 * t_1)).sqrt());
    let u = ((r_hit / m_1) / ((r_hit / m_1) + 1.0)).powf(g);
    let m = m_1 / u;
    let w_i = (n / 100.0).ln() / 2.0_f64.ln();
    let c_t = c_d / n_r * (1.0 + w_i * w_g);
    let g_ip = 0.5 * (c_t + (c_t * (c_t + 4.0 * t_1)).sqrt());
    let g_ipp2 = -(m_1 * (g_ip / m).powf(1.0 / g)) / ((g_ip / m).powf(1.0 / g) - 1.0);
    let w_2 = c / g_ipp2;
    let s_2 = w_2 * m_1;
    let u_2 = ((r_hit / m_1) / ((r_hit / m_1) + w_2)).powf(g);
    let m_2 = m_1 / u_2;
    let f = m_2 * (x.max(0.0) / (x + s_2)).powf(g);
    (f * f / (f + t_1)).max(0.0)
}

/// The factor of the light with which a rising curve makes 0.18 of 0.18.
pub(crate) fn matched_scale(curve: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1.0 / 16.0, 16.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if curve(0.18 * middle) < 0.18 { low = middle } else { high = middle }
    }
    low
}

/// A channel that is at least `least`, smoothly: a parabola between 0 and twice of it.
pub(crate) fn soft_floor(x: f64, least: f64) -> f64 {
    match x {
        _ if x >= 2.0 * least => x,
        _ if x <= 0.0 => least,
        _ => least + x * x / (4.0 * least),
    }
}

/// Light in the working space of a curve that reaches `peak`, with a tenth of its mean in every channel where it is
/// bright.
pub(crate) fn whitened(light: Rgb, peak: f64) -> Rgb {
    let mean = light.map(|x| x.max(0.0)).iter().sum::<f64>() / 3.0;
    let least = 0.1 * mean * mean / (peak + mean);
    light.map(|x| soft_floor(x, least))
}

/// Narkowicz's fit of ACES 1 (2016); its clamp at 1 belongs to the curve.
pub(crate) fn narkowicz(x: f64) -> f64 {
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// The input matrix of Hill's fit as published, to five digits.
pub(crate) const HILL_IN: Matrix =
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];

/// The output matrix of Hill's fit as published, to five digits.
pub(crate) const HILL_OUT: Matrix =
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];

/// Hill's fit of the RRT and ODT of ACES 1, clamped to [0, 1].
pub(crate) fn hill(rgb: Rgb) -> Rgb {
    let fit = |v: f64| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    display(transform(&HILL_OUT, transform(&HILL_IN, rgb).map(fit)))
}

/// Hable's curve (Uncharted 2, 2010) of `bias · x`, scaled so that `white` gives 1, then clamped.
/// The usual form subtracts two nearly equal numbers at black; this one has them folded.
pub(crate) fn hable(x: f64, bias: f64, white: f64) -> f64 {
    let (a, b, c, d, e, f) = (0.15, 0.50, 0.10, 0.20, 0.02, 0.30);
    let curve = |x: f64| x * (a * (1.0 - e / f) * x + (c - e / f) * b) / (x * (a * x + b) + d * f);
    (curve(bias * x) / curve(white)).clamp(0.0, 1.0)
}

/// The parameters of Uchimura's curve (CEDEC 2017).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uchimura {
    /// The output that bright light tends to.
    pub(crate) maximum: f64,
    /// The slope of the linear part.
    pub(crate) contrast: f64,
    /// The start of the linear part.
    pub(crate) start: f64,
    /// The share of the range above `start` that is linear.
    pub(crate) length: f64,
    /// The exponent of the toe.
    pub(crate) toe: f64,
    /// The offset that the toe adds to black.
    pub(crate) pedestal: f64,
}

pub(crate) const UCHIMURA: Uchimura =
    Uchimura { maximum: 1.0, contrast: 1.0, start: 0.22, length: 0.4, toe: 1.33, pedestal: 0.0 };

/// Uchimura's curve: a toe, a line and a shoulder, blended.
pub(crate) fn uchimura(x: f64, curve: &Uchimura) -> f64 {
    let Uchimura { maximum: p, contrast: a, toe: c, pedestal: b, .. } = *curve;
    let m = curve.start.max(1e-4);
    let line_length = (p - m) * curve.length.min(0.999) / a;
    let (s0, s1) = (m + line_length, m + a * line_length);
    let steepness = a * p / (p - s1);

    let toe = m * (x.max(0.0) / m).powf(c) + b;
    let line = m + a * (x - m);
    let shoulder = p - (p - s1) * (-steepness * (x.max(s0) - s0) / p).exp();

    let toe_weight = 1.0 - smooth_step(0.0, m, x);
    let shoulder_weight = if x >= s0 { 1.0 } else { 0.0 };
    let line_weight = 1.0 - toe_weight - shoulder_weight;
    (toe * toe_weight + line * line_weight + shoulder * shoulder_weight).max(0.0)
}

/// The Khronos PBR Neutral tone mapper: `start` (0.8 as published) less the Fresnel offset of
/// 0.04 is where compression begins; `desaturation` (0.15) pulls highlights to white.
pub(crate) fn pbr_neutral(rgb: Rgb, start: f64, desaturation: f64) -> Rgb {
    let fresnel = 0.04;
    let knee = start - fresnel;
    let least = rgb[0].min(rgb[1]).min(rgb[2]);
    let offset = if least < 0.08 { least - least * least / (4.0 * fresnel) } else { fresnel };
    let rgb = rgb.map(|x| x - offset);
    let peak = largest(rgb);
    if peak < knee {
        return rgb;
    }
    let d = 1.0 - knee;
    let new_peak = 1.0 - d * d / (peak + d - knee);
    let gray = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    rgb.map(|x| mix(x * new_peak / peak, new_peak, gray))
}

/// Runs a one-channel curve in `space` on linear Rec.709 and clamps the result to [0, 1]
/// (formula book, 10).
pub(crate) fn in_space(rgb: Rgb, space: &Space, curve: impl Fn(f64) -> f64) -> Rgb {
    let inside = transform(&conversion(&REC709, space), rgb).map(|x| curve(x.max(0.0)));
    display(transform(&conversion(space, &REC709), inside))
}

#[test]
fn degenerate_uchimura_parameters_stay_finite() {
    for broken in [Uchimura { start: 0.0, ..UCHIMURA }, Uchimura { length: 1.0, ..UCHIMURA }] {
        for x in [0.0, 1e-30, 0.1, 1.0, 65504.0] {
            let y = uchimura(x, &broken);
            assert!(y.is_finite() && (0.0..=1.001).contains(&y), "{broken:?} at {x}: {y}");
        }
    }
}
