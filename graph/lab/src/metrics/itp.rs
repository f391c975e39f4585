//! dE ITP: color difference of HDR images (ITU-R BT.2124).

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::color::pq_of_nits;

/// Rec.709 to Rec.2020 (ITU-R BT.2087).
pub const REC2020: DMat3 = DMat3::from_cols(
    DVec3::new(0.627_403_895_934_70, 0.069_097_289_358_23, 0.016_391_438_875_15),
    DVec3::new(0.329_283_038_377_89, 0.919_540_395_075_46, 0.088_013_307_877_22),
    DVec3::new(0.043_313_065_687_42, 0.011_362_315_566_31, 0.895_595_253_247_63),
);

/// Rec.2020 to cone responses (ITU-R BT.2100).
const LMS: DMat3 = DMat3::from_cols(
    DVec3::new(1688.0 / 4096.0, 683.0 / 4096.0, 99.0 / 4096.0),
    DVec3::new(2146.0 / 4096.0, 2951.0 / 4096.0, 309.0 / 4096.0),
    DVec3::new(262.0 / 4096.0, 462.0 / 4096.0, 3688.0 / 4096.0),
);

/// I, T and P of linear Rec.709 in cd/m²: ICtCp with the first chroma axis halved.
fn itp(nits: [f32; 3]) -> DVec3 {
    let nits = DVec3::from_array(nits.map(f64::from));
    let [l, m, s] = (LMS * (REC2020 * nits)).to_array().map(pq_of_nits);
    let ct = (6610.0 * l - 13613.0 * m + 7003.0 * s) / 4096.0;
    let cp = (17933.0 * l - 17390.0 * m - 543.0 * s) / 4096.0;
    DVec3::new((l + m) / 2.0, ct / 2.0, cp)
}

/// The difference of two colors in cd/m², linear Rec.709; 1 is just noticeable.
pub fn delta_e_itp_of(reference: [f32; 3], other: [f32; 3]) -> f64 {
    720.0 * itp(reference).distance(itp(other))
}

/// The difference of each pixel.
pub fn delta_e_itp(reference: &[[f32; 3]], other: &[[f32; 3]]) -> Vec<f32> {
    reference.par_iter().zip(other).map(|(a, b)| if a == b { 0.0 } else { delta_e_itp_of(*a, *b) as f32 }).collect()
}
