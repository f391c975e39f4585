//! Oklab (Ottosson 2020) in double precision: hue, and a gamut step that keeps it.

use std::sync::LazyLock;

use afterimage_graph::color::Chromaticities;
use glam::{DMat3, DVec2, DVec3, dvec3};

use crate::bisection::bisected;

/// Linear Rec.709 to the cone responses of Oklab, as published. White becomes 1, 1, 1.
const LMS_FROM_REC709: DMat3 = DMat3::from_cols(
    dvec3(0.4122214708, 0.2119034982, 0.0883024619),
    dvec3(0.5363325363, 0.6806995451, 0.2817188376),
    dvec3(0.0514459929, 0.1073969566, 0.6299787005),
);

/// The cube roots of the cone responses to lightness, a and b, as published.
const LAB_FROM_ROOTS: DMat3 = DMat3::from_cols(
    dvec3(0.2104542553, 1.9779984951, 0.0259040371),
    dvec3(0.7936177850, -2.4285922050, 0.7827717662),
    dvec3(-0.0040720468, 0.4505937099, -0.8086757660),
);

static REC709_FROM_LMS: LazyLock<DMat3> = LazyLock::new(|| LMS_FROM_REC709.inverse());

static ROOTS_FROM_LAB: LazyLock<DMat3> = LazyLock::new(|| LAB_FROM_ROOTS.inverse());

/// Linear RGB to the cone responses of Oklab. White becomes 1, 1, 1.
pub fn lms_from_rgb(space: &Chromaticities) -> DMat3 {
    LMS_FROM_REC709 * space.conversion(&Chromaticities::REC709)
}

/// The inverse of [`lms_from_rgb`].
pub fn rgb_from_lms(space: &Chromaticities) -> DMat3 {
    Chromaticities::REC709.conversion(space) * *REC709_FROM_LMS
}

/// A color of Oklab.
#[derive(Clone, Copy, Debug)]
pub struct Lab {
    lightness: f64,
    chroma: DVec2,
}

impl Lab {
    /// From linear Rec.709, also with negative channels.
    pub fn of(rgb: DVec3) -> Self {
        let roots = DVec3::from((LMS_FROM_REC709 * rgb).to_array().map(f64::cbrt));
        let lab = LAB_FROM_ROOTS * roots;
        Self { lightness: lab.x, chroma: DVec2::new(lab.y, lab.z) }
    }

    /// To linear Rec.709.
    pub fn rgb(self) -> DVec3 {
        let roots = ROOTS_FROM_LAB.mul_vec3(dvec3(self.lightness, self.chroma.x, self.chroma.y));
        REC709_FROM_LMS.mul_vec3(roots * roots * roots)
    }

    /// This lightness and amount of chroma, with a share of another color's hue.
    pub fn with_hue_of(self, other: Self, share: f64) -> Self {
        let amount = self.chroma.length();
        let target = other.chroma * (amount / other.chroma.length().max(1e-20));
        let mixed = self.chroma.lerp(target, share);
        Self { chroma: mixed * (amount / mixed.length().max(1e-20)), ..self }
    }

    /// The color of this hue in the gamut from 0 to `peak` of the primaries that `display` converts Rec.709 to, and in
    /// these primaries. Up to the share `knee` of the gamut's chroma nothing changes; x / (1 + x) compresses the rest.
    pub fn fitted(self, display: &DMat3, peak: f64, knee: f64) -> DVec3 {
        let knee = knee.max(1e-3);
        let clamped = Self { lightness: self.lightness.clamp(0.0, peak.cbrt()), ..self };
        let scaled = |share: f64| *display * Self { chroma: clamped.chroma * share, ..clamped }.rgb();
        let is_inside = |share: f64| {
            let rgb = scaled(share);
            rgb.min_element() >= 0.0 && rgb.max_element() <= peak
        };
        if is_inside(1.0 / knee) {
            return scaled(1.0);
        }
        // The share of the chroma that reaches the border, through a variable whose steps are finer near 1.
        let stretched = |u: f64| u / (1.0 - u * (1.0 - knee));
        let border = stretched(bisected(0.0, 1.0, |u| is_inside(stretched(u))));
        let over = 1.0 - knee * border;
        let share = border * (knee + (1.0 - knee) * over / ((1.0 - knee) * border + over).max(1e-20));
        scaled(share.min(1.0)).clamp(DVec3::ZERO, DVec3::splat(peak))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_color_comes_back_and_white_has_no_chroma() {
        for rgb in [dvec3(0.2, 0.5, 0.1), dvec3(-0.1, 0.3, 4.0), DVec3::ZERO] {
            assert!((Lab::of(rgb).rgb() - rgb).abs().max_element() < 1e-7, "{rgb}");
        }
        let white = Lab::of(DVec3::ONE);
        assert!((white.lightness - 1.0).abs() < 1e-7 && white.chroma.length() < 1e-7, "{white:?}");
    }

    #[test]
    fn the_published_example_of_red() {
        let red = Lab::of(DVec3::X);
        let expected = [0.6279554, 0.2248631, 0.1258463];
        let found = [red.lightness, red.chroma.x, red.chroma.y];
        assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn outer_colors_are_fitted_on_their_hue_and_lightness() {
        for rgb in [dvec3(1.4, 0.2, -0.1), dvec3(0.1, -0.05, 0.9), dvec3(0.4, 0.9, -0.2)] {
            let (source, fitted) = (Lab::of(rgb), Lab::of(Lab::of(rgb).fitted(&DMat3::IDENTITY, 1.0, 0.8)));
            assert!((source.lightness - fitted.lightness).abs() < 1e-6, "{rgb}");
            assert!(source.chroma.angle_to(fitted.chroma).abs() < 1e-5, "{rgb}");
            assert!(fitted.chroma.length() < source.chroma.length(), "{rgb}");
        }
    }
}
