//! The Gran Turismo 7 tone mapper (Uchimura, SIGGRAPH 2025): Rec.2020 in and out, 1.0 is
//! 100 cd/m².

use super::math::{Matrix, Rgb, inverse, mix, smooth_step, transform};
use super::transfer::{pq_decode, pq_encode};

/// Rec.2020 to the cone responses of ICtCp (ITU-R BT.2100).
pub(crate) const LMS_FROM_REC2020: Matrix =
    over_4096([[1688.0, 2146.0, 262.0], [683.0, 2951.0, 462.0], [99.0, 309.0, 3688.0]]);

/// PQ-encoded cone responses to ICtCp (ITU-R BT.2100).
pub(crate) const ICTCP_FROM_LMS: Matrix =
    over_4096([[2048.0, 2048.0, 0.0], [6610.0, -13613.0, 7003.0], [17933.0, -17390.0, -543.0]]);

const fn over_4096(m: Matrix) -> Matrix {
    let [[a, b, c], [d, e, f], [g, h, i]] = m;
    let n = 4096.0;
    [[a / n, b / n, c / n], [d / n, e / n, f / n], [g / n, h / n, i / n]]
}

/// The curve of one channel for a display with a peak of `peak` frame-buffer units.
pub(crate) fn curve(x: f64, peak: f64) -> f64 {
    let (alpha, middle, linear_end, toe) = (0.25, 0.538, 0.444, 1.28);
    if x < linear_end * peak {
        let x = x.max(0.0);
        let toe = middle * (x / middle).powf(toe);
        return mix(toe, x, smooth_step(0.0, middle, x));
    }
    let k = (linear_end - 1.0) / (alpha - 1.0);
    let a = peak * linear_end + peak * k;
    let b = -peak * k * (linear_end / k).exp();
    a + b * (-x / (k * peak)).exp()
}

/// Rec.2020 to ICtCp.
pub(crate) fn to_ictcp(rgb: Rgb) -> Rgb {
    let encoded = transform(&LMS_FROM_REC2020, rgb).map(|x| pq_encode(100.0 * x));
    transform(&ICTCP_FROM_LMS, encoded)
}

/// ICtCp to Rec.2020; negative channels become 0. As in the published sample, cone responses end at 10 000 cd/m2 here.
pub(crate) fn from_ictcp(ictcp: Rgb) -> Rgb {
    let lms = transform(&inverse(&ICTCP_FROM_LMS), ictcp).map(|x| pq_decode(x.min(1.0)) / 100.0);
    transform(&inverse(&LMS_FROM_REC2020), lms).map(|x| x.max(0.0))
}

/// The whole operator for an HDR display of `nits`: a per-channel result blended with one whose
/// chroma fades at the top.
pub(crate) fn hdr(rgb: Rgb, nits: f64) -> Rgb {
    let peak = nits / 100.0;
    let rgb = rgb.map(|x| x.max(0.0));
    let skewed = rgb.map(|x| curve(x, peak));
    let [own, ct, cp] = to_ictcp(rgb);
    let fade = 1.0 - smooth_step(0.98, 1.16, own / to_ictcp([peak; 3])[0]);
    let scaled = from_ictcp([to_ictcp(skewed)[0], ct * fade, cp * fade]);
    [0, 1, 2].map(|i| mix(skewed[i], scaled[i], 0.6).min(peak))
}

/// The SDR form: mapped for 250 cd/m², whose peak becomes 1.
pub(crate) fn sdr(rgb: Rgb) -> Rgb {
    hdr(rgb, 250.0).map(|x| x / 2.5)
}
