//! PU21: luminance as codes that are perceptually uniform.

/// Mantiuk and Azimi, "PU21: a novel perceptually uniform encoding for adapting existing quality metrics for HDR",
/// Picture Coding Symposium 2021: the parameters of the variant `banding_glare`, which they recommend.
const P: [f64; 7] =
    [0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166, 0.9099517204, 596.3148142];

/// The code of a luminance in cd/m²: 0 at 0.005, 256 at 100, 595.4 at 10000; luminance outside is clamped.
pub fn pu21(nits: f64) -> f64 {
    let power = nits.clamp(0.005, 10_000.0).powf(P[3]);
    let inner = (P[0] + P[1] * power) / (1.0 + P[2] * power);
    (P[6] * (inner.powf(P[4]) - P[5])).max(0.0)
}
