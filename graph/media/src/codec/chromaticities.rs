//! From any RGB primaries to linear Rec.709 with D65 white.

use afterimage_base::color::{Chromaticities, Xy};
use glam::DMat3;

/// Files round their chromaticities, so primaries that differ by less count as equal.
const TOLERANCE: f64 = 1e-3;

/// The tristimulus values themselves. Their "white" is the equal-energy point by definition and
/// not a white that an eye adapted to, so nothing is to be carried over: OpenEXR's own test
/// images `XYZ.exr` and `Rec709.exr` agree only this way.
pub(crate) const CIE_XYZ: Chromaticities = Chromaticities {
    red: Xy::new(1.0, 0.0),
    green: Xy::new(0.0, 1.0),
    blue: Xy::new(0.0, 0.0),
    white: Xy::new(1.0 / 3.0, 1.0 / 3.0),
};

/// The white that pixels with these primaries are adapted from or to: D65 for tristimulus values, which have none.
pub(crate) fn adopted_white(primaries: &Chromaticities) -> Xy {
    if primaries.close_to(&CIE_XYZ, TOLERANCE) { Xy::D65 } else { primaries.white }
}

/// The matrix from one RGB space to another, either of which may be tristimulus values; `None` where their primaries
/// are the same within 1e-3.
pub(crate) fn conversion(from: &Chromaticities, to: &Chromaticities) -> Option<DMat3> {
    if from.close_to(to, TOLERANCE) {
        return None;
    }
    let d65 = Chromaticities::REC709;
    Some(if from.close_to(&CIE_XYZ, TOLERANCE) {
        d65.conversion(to) * d65.to_xyz().inverse()
    } else if to.close_to(&CIE_XYZ, TOLERANCE) {
        d65.to_xyz() * from.conversion(&d65)
    } else {
        from.conversion(to)
    })
}

/// The matrix to linear Rec.709, or `None` where the primaries are Rec.709's within 1e-3.
pub(crate) fn to_rec709(from: &Chromaticities) -> Option<DMat3> {
    conversion(from, &Chromaticities::REC709)
}

/// Converts the color of one pixel. Infinities count as ±65504 and NaN as 0, so that one
/// overflowed channel does not turn the other two into NaN; negatives are kept.
pub(crate) fn convert(matrix: &glam::Mat3, rgb: [f32; 3]) -> [f32; 3] {
    (*matrix * glam::Vec3::from(rgb.map(bounded))).to_array()
}

fn bounded(value: f32) -> f32 {
    const HALF_MAX: f32 = 65504.0;
    match value {
        v if v.is_nan() => 0.0,
        v if v.is_infinite() => HALF_MAX.copysign(v),
        v => v.clamp(-1e37, 1e37),
    }
}
