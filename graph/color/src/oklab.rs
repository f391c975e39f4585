//! The cone responses of Oklab (Ottosson 2020) in double precision.

use std::sync::LazyLock;

use afterimage_graph::color::Chromaticities;
use glam::{DMat3, dvec3};

/// Linear Rec.709 to the cone responses of Oklab, as published. White becomes 1, 1, 1.
const LMS_FROM_REC709: DMat3 = DMat3::from_cols(
    dvec3(0.4122214708, 0.2119034982, 0.0883024619),
    dvec3(0.5363325363, 0.6806995451, 0.2817188376),
    dvec3(0.0514459929, 0.1073969566, 0.6299787005),
);

static REC709_FROM_LMS: LazyLock<DMat3> = LazyLock::new(|| LMS_FROM_REC709.inverse());

/// Linear RGB to the cone responses of Oklab. White becomes 1, 1, 1.
pub fn lms_from_rgb(space: &Chromaticities) -> DMat3 {
    LMS_FROM_REC709 * space.conversion(&Chromaticities::REC709)
}

/// The inverse of [`lms_from_rgb`].
pub fn rgb_from_lms(space: &Chromaticities) -> DMat3 {
    Chromaticities::REC709.conversion(space) * *REC709_FROM_LMS
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn white_has_equal_responses_in_all_primaries() {
        for space in [Chromaticities::REC709, Chromaticities::DISPLAY_P3, Chromaticities::REC2020] {
            let white = lms_from_rgb(&space) * DVec3::ONE;
            assert!((white - 1.0).abs().max_element() < 1e-6, "{white}");
            assert!((rgb_from_lms(&space) * lms_from_rgb(&space)).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
    }
}
