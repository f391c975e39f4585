//! Color spaces that the metrics need. Matrices follow from the primaries of ITU-R BT.709 and the white D65 (0.3127,
//! 0.3290).

use afterimage_graph::color::Transfer;
use glam::{DMat3, DVec3};

/// Linear Rec.709 to XYZ, Y of white 1; columns are the primaries.
pub(super) const XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_799_265_96, 0.212_639_005_871_51, 0.019_330_818_715_59),
    DVec3::new(0.357_584_339_383_88, 0.715_168_678_767_76, 0.119_194_779_794_63),
    DVec3::new(0.180_480_788_401_83, 0.072_192_315_360_73, 0.950_532_152_249_66),
);

pub(super) fn white() -> DVec3 {
    XYZ * DVec3::ONE
}

/// The linear value of an sRGB signal (IEC 61966-2-1), both limited to 0 to 1.
pub fn srgb_decode(signal: f64) -> f64 {
    Transfer::Srgb.to_light(signal)
}

/// The sRGB signal of a linear value, both limited to 0 to 1.
pub fn srgb_encode(linear: f64) -> f64 {
    Transfer::Srgb.to_signal(linear)
}

/// CIELAB of an sRGB signal, white D65.
pub fn lab_of_srgb(signal: [f32; 3]) -> [f64; 3] {
    let linear = DVec3::from_array(signal.map(|x| srgb_decode(f64::from(x))));
    lab(XYZ * linear)
}

/// CIELAB (CIE 15) of XYZ with the white of sRGB.
pub(super) fn lab(xyz: DVec3) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = (xyz / white()).to_array().map(f);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The PQ signal of a luminance in cd/m² (SMPTE ST 2084).
pub(super) fn pq_of_nits(nits: f64) -> f64 {
    Transfer::Pq.to_signal(nits / 10_000.0)
}

/// The luminance in cd/m² of a PQ signal.
pub fn nits_of_pq(signal: f64) -> f64 {
    10_000.0 * Transfer::Pq.to_light(signal)
}
