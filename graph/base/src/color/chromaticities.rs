//! Primaries and white points, and the matrices between RGB spaces.

use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{Cones, Decimal};

/// A chromaticity: CIE 1931 x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Xy {
    /// X / (X + Y + Z).
    pub x: Decimal,
    /// Y / (X + Y + Z).
    pub y: Decimal,
}

impl Xy {
    /// The white of sRGB, Rec.709, Display P3 and Rec.2020.
    pub const D65: Self = Self::new(0.3127, 0.3290);
    /// The white of the ACES spaces, near D60.
    pub const ACES: Self = Self::new(0.32168, 0.33767);

    /// The chromaticity with these coordinates, in steps of 1e-6.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x: Decimal::new(x), y: Decimal::new(y) }
    }

    /// x and y.
    pub fn to_vec(self) -> DVec2 {
        DVec2::new(self.x.get(), self.y.get())
    }

    /// x, y and z, which sum to 1.
    fn xyz(self) -> DVec3 {
        let DVec2 { x, y } = self.to_vec();
        DVec3::new(x, y, 1.0 - x - y)
    }

    /// XYZ with Y = 1. Not finite for y = 0.
    pub fn to_xyz(self) -> DVec3 {
        let DVec2 { x, y } = self.to_vec();
        DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
    }
}

impl From<[f32; 2]> for Xy {
    fn from([x, y]: [f32; 2]) -> Self {
        Self { x: x.into(), y: y.into() }
    }
}

impl From<DVec2> for Xy {
    fn from(xy: DVec2) -> Self {
        Self::new(xy.x, xy.y)
    }
}

/// The primaries and the white of an RGB space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Chromaticities {
    /// The chromaticity of (1, 0, 0).
    pub red: Xy,
    /// The chromaticity of (0, 1, 0).
    pub green: Xy,
    /// The chromaticity of (0, 0, 1).
    pub blue: Xy,
    /// The chromaticity of (1, 1, 1).
    pub white: Xy,
}

impl Chromaticities {
    /// ITU-R BT.709, also sRGB: the primaries of the images in a graph.
    pub const REC709: Self =
        Self { red: Xy::new(0.640, 0.330), green: Xy::new(0.300, 0.600), blue: Xy::new(0.150, 0.060), white: Xy::D65 };

    /// Display P3: SMPTE EG 432-1 with D65 white.
    pub const DISPLAY_P3: Self =
        Self { red: Xy::new(0.680, 0.320), green: Xy::new(0.265, 0.690), blue: Xy::new(0.150, 0.060), white: Xy::D65 };

    /// ITU-R BT.2020, also BT.2100.
    pub const REC2020: Self =
        Self { red: Xy::new(0.708, 0.292), green: Xy::new(0.170, 0.797), blue: Xy::new(0.131, 0.046), white: Xy::D65 };

    /// AP1: the primaries of ACEScg (Academy S-2014-004).
    pub const ACES_CG: Self =
        Self { red: Xy::new(0.713, 0.293), green: Xy::new(0.165, 0.830), blue: Xy::new(0.128, 0.044), white: Xy::ACES };

    /// AP0: the primaries of ACES2065-1 (SMPTE ST 2065-1).
    pub const ACES_AP0: Self = Self {
        red: Xy::new(0.7347, 0.2653),
        green: Xy::new(0.0, 1.0),
        blue: Xy::new(0.0001, -0.0770),
        white: Xy::ACES,
    };

    /// The space of x and y of red, green, blue and white, as files state them. `None` if a number is not finite or far
    /// outside of 0 to 1, and if the space is not [usable](Self::is_usable).
    pub fn from_numbers(numbers: [f64; 8]) -> Option<Self> {
        let plausible = numbers.iter().all(|number| number.abs() <= 100.0);
        let [rx, ry, gx, gy, bx, by, wx, wy] = numbers;
        let [red, green, blue, white] = [[rx, ry], [gx, gy], [bx, by], [wx, wy]].map(|[x, y]| Xy::new(x, y));
        Some(Self { red, green, blue, white }).filter(|space| plausible && space.is_usable())
    }

    /// The four chromaticities in the order red, green, blue, white.
    pub fn points(&self) -> [Xy; 4] {
        [self.red, self.green, self.blue, self.white]
    }

    /// The name of a well-known space: `Rec709`, `DisplayP3`, `Rec2020`, `AcesCg` or `Ap0`.
    pub fn name(&self) -> Option<&'static str> {
        match *self {
            Self::REC709 => Some("Rec709"),
            Self::DISPLAY_P3 => Some("DisplayP3"),
            Self::REC2020 => Some("Rec2020"),
            Self::ACES_CG => Some("AcesCg"),
            Self::ACES_AP0 => Some("Ap0"),
            _ => None,
        }
    }

    /// Returns whether every coordinate differs by less than `tolerance`.
    pub fn close_to(&self, other: &Self, tolerance: f64) -> bool {
        let mut pairs = self.points().into_iter().zip(other.points());
        pairs.all(|(a, b)| (a.to_vec() - b.to_vec()).abs().max_element() < tolerance)
    }

    /// Returns whether the primaries span a triangle and white has a positive y, so that the matrices exist.
    pub fn is_usable(&self) -> bool {
        self.primaries().determinant().abs() >= 1e-6 && self.white.y.get() >= 1e-3
    }

    fn primaries(&self) -> DMat3 {
        DMat3::from_cols(self.red.xyz(), self.green.xyz(), self.blue.xyz())
    }

    /// Linear RGB to XYZ with white at Y = 1: `P · diag(P⁻¹ W)` (SMPTE RP 177). Not finite if
    /// [`is_usable`](Self::is_usable) is false.
    pub fn to_xyz(&self) -> DMat3 {
        let primaries = self.primaries();
        primaries * DMat3::from_diagonal(primaries.inverse() * self.white.to_xyz())
    }

    /// Linear RGB of this space to that of `destination`. The white is adapted by the Bradford transform (ICC.1:2022,
    /// annex E), so that (1, 1, 1) stays (1, 1, 1). Not finite if one of the spaces is not usable.
    pub fn conversion(&self, destination: &Self) -> DMat3 {
        if self == destination {
            return DMat3::IDENTITY;
        }
        let adapt = Cones::Bradford.adaptation(self.white.to_xyz(), destination.white.to_xyz());
        destination.to_xyz().inverse() * adapt * self.to_xyz()
    }
}
