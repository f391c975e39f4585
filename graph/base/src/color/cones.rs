//! Chromatic adaptation by scaling cone responses.

use glam::{DMat3, DVec3};

/// The cone responses that chromatic adaptation scales.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cones {
    /// Lam's Bradford transform (1985).
    Bradford,
    /// CAT16 (Li et al. 2017).
    Cat16,
}

impl Cones {
    /// XYZ to cone responses.
    pub fn matrix(self) -> DMat3 {
        let rows = match self {
            Self::Bradford => [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
            Self::Cat16 => {
                [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]]
            }
        };
        DMat3::from_cols_array_2d(&rows).transpose()
    }

    /// The matrix on XYZ that maps the white `source` to the white `destination`.
    pub fn adaptation(self, source: DVec3, destination: DVec3) -> DMat3 {
        if source == destination {
            return DMat3::IDENTITY;
        }
        let cones = self.matrix();
        cones.inverse() * DMat3::from_diagonal((cones * destination) / (cones * source)) * cones
    }
}
