//! From any RGB primaries to linear Rec.709 with D65 white, by matrices made in f64.
//!
//! `P · diag(P⁻¹ W)` takes RGB to XYZ (SMPTE RP 177); the white point is carried over by the
//! linear Bradford transform (ICC.1:2022, annex E).

use glam::{DMat3, DVec2, DVec3};

/// CIE xy of the three primaries and of white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Where (1, 0, 0) lies.
    pub red: DVec2,
    /// Where (0, 1, 0) lies.
    pub green: DVec2,
    /// Where (0, 0, 1) lies.
    pub blue: DVec2,
    /// Where (1, 1, 1) lies.
    pub white: DVec2,
}

/// ITU-R BT.709, the primaries of the scene everywhere in the program.
pub const REC709: Primaries = Primaries {
    red: DVec2::new(0.640, 0.330),
    green: DVec2::new(0.300, 0.600),
    blue: DVec2::new(0.150, 0.060),
    white: DVec2::new(0.3127, 0.3290),
};

const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// Primaries that span no colour space: on one line, white without luminance, or not numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotAColourSpace;

impl Primaries {
    fn points(&self) -> [DVec2; 4] {
        [self.red, self.green, self.blue, self.white]
    }

    /// Closer than one thousandth in every coordinate.
    fn close_to(&self, other: &Self) -> bool {
        let pairs = self.points().into_iter().zip(other.points());
        pairs.into_iter().all(|(a, b)| (a - b).abs().max_element() < 1e-3)
    }

    /// The tristimulus values themselves. Their "white" is the equal-energy point by definition and
    /// not a white that an eye adapted to, so nothing is to be carried over: OpenEXR's own test
    /// images `XYZ.exr` and `Rec709.exr` agree only this way.
    fn is_cie_xyz(&self) -> bool {
        let [red, green] = [DVec2::X, DVec2::Y];
        let white = DVec2::splat(1.0 / 3.0);
        self.close_to(&Self { red, green, blue: DVec2::ZERO, white })
    }

    fn to_xyz(self) -> Result<DMat3, NotAColourSpace> {
        let xyz = |at: DVec2| DVec3::new(at.x, at.y, 1.0 - at.x - at.y);
        let primaries = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        let sound = self.points().iter().all(|point| point.is_finite())
            && primaries.determinant().abs() >= 1e-6
            && self.white.y.abs() >= 1e-6;
        if !sound {
            return Err(NotAColourSpace);
        }
        let scale = primaries.inverse() * (xyz(self.white) / self.white.y);
        Ok(primaries * DMat3::from_diagonal(scale))
    }
}

/// The matrix to linear Rec.709, or `None` where the primaries are Rec.709's within 1e-3.
pub(crate) fn to_rec709(from: &Primaries) -> Result<Option<DMat3>, NotAColourSpace> {
    if from.close_to(&REC709) {
        return Ok(None);
    }
    let source = from.to_xyz()?;
    let rec709 = REC709.to_xyz()?;
    if from.is_cie_xyz() {
        return Ok(Some(rec709.inverse() * source));
    }
    let cones = |to_xyz: DMat3| BRADFORD * to_xyz * DVec3::ONE;
    let gain = cones(rec709) / cones(source);
    let adapt = BRADFORD.inverse() * DMat3::from_diagonal(gain) * BRADFORD;
    let matrix = rec709.inverse() * adapt * source;
    if matrix.is_finite() { Ok(Some(matrix)) } else { Err(NotAColourSpace) }
}

/// Converts the colour of one pixel. Infinities count as ±65504 and NaN as 0, so that one
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
