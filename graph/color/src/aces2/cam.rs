//! The color appearance model of ACES 2.0: lightness J, colorfulness M and hue h after CAM16 (Li et al. 2017), as
//! simplified by Hellwig and Fairchild (2022), for a dim surround.

use afterimage_graph::color::{Chromaticities, Xy};
use glam::{DMat3, DVec2, DVec3, dvec3};

/// The luminance of white in the model, in cd/m².
pub(super) const REFERENCE: f64 = 100.0;

/// The factors F, c and N_c of a dim surround.
const SURROUND: [f64; 3] = [0.9, 0.59, 0.9];

/// The adapting luminance in cd/m², and the relative luminance of the background.
const ADAPTING: f64 = 100.0;
const BACKGROUND: f64 = 20.0;

/// The offset of the compression of cone responses.
const CONE_OFFSET: f64 = 27.13;

/// The primaries of CAM16's cone responses.
const CONES: Chromaticities = Chromaticities {
    red: Xy::new(0.8336, 0.1735),
    green: Xy::new(2.3854, -1.4659),
    blue: Xy::new(0.087, -0.125),
    white: Xy::new(0.333, 0.333),
};

/// The response to luminance of a mean adaptation.
fn adaptation_level() -> f64 {
    let k = 1.0 / (5.0 * ADAPTING + 1.0);
    let k4 = k.powi(4);
    0.2 * k4 * (5.0 * ADAPTING) + 0.1 * (1.0 - k4).powi(2) * (5.0 * ADAPTING).cbrt()
}

/// The exponent from achromatic response to J.
pub(super) fn lightness_exponent() -> f64 {
    SURROUND[1] * (1.48 + (BACKGROUND / REFERENCE).sqrt())
}

/// Cone responses to compressed ones.
fn compress(v: f64) -> f64 {
    let power = v.abs().powf(0.42);
    (power / (CONE_OFFSET + power)).copysign(v)
}

fn expand(v: f64) -> f64 {
    let limited = v.abs().min(0.99);
    (CONE_OFFSET * limited / (1.0 - limited)).powf(1.0 / 0.42).copysign(v)
}

/// Lightness, colorfulness, and hue as a point of the unit circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jmh {
    pub(super) j: f64,
    pub(super) m: f64,
    pub(super) hue: DVec2,
}

impl Jmh {
    /// The hue in degrees, 0 to 360.
    pub(super) fn degrees(self) -> f64 {
        self.hue.y.atan2(self.hue.x).to_degrees().rem_euclid(360.0)
    }
}

/// The point of the unit circle at a hue in degrees.
pub(super) fn direction(degrees: f64) -> DVec2 {
    DVec2::from_angle(degrees.to_radians())
}

/// The model for linear RGB of some primaries. White is adapted completely, so 1, 1, 1 has no colorfulness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Model {
    /// RGB to cone responses.
    cones: DMat3,
    /// Compressed cone responses to the achromatic response A and the opponents a and b.
    opponents: DMat3,
    cones_inverse: DMat3,
    opponents_inverse: DMat3,
    level: f64,
    white: f64,
    exponent: f64,
}

impl Model {
    pub(super) fn new(space: Chromaticities) -> Self {
        let xyz_to_cones = CONES.to_xyz().inverse();
        let white = xyz_to_cones * (space.to_xyz() * DVec3::splat(REFERENCE));
        let level = adaptation_level();
        // White has the luminance of the reference in every space.
        let gains = DVec3::splat(level) / white;
        let cones = DMat3::from_diagonal(gains) * xyz_to_cones * space.to_xyz() * REFERENCE;
        let white = compress(level);
        let opponents = Self::opponents(DVec3::splat(white));
        Self {
            cones,
            opponents,
            cones_inverse: cones.inverse(),
            opponents_inverse: opponents.inverse(),
            level: level / REFERENCE,
            white,
            exponent: lightness_exponent(),
        }
    }

    /// The matrix of the opponents. `white` is the compressed response to white, for which A is 1.
    fn opponents(white: DVec3) -> DMat3 {
        let achromatic = dvec3(2.0, 1.0, 1.0 / 20.0);
        let color = 4.0 * REFERENCE * 43.0 * SURROUND[2];
        let a = color * dvec3(1.0, -12.0 / 11.0, 1.0 / 11.0);
        let b = color / 9.0 * dvec3(1.0, 1.0, -2.0);
        DMat3::from_cols(achromatic / achromatic.dot(white), a, b).transpose()
    }

    /// The achromatic response A and the opponents a and b.
    pub(super) fn response(&self, rgb: DVec3) -> DVec3 {
        self.opponents * DVec3::from((self.cones * rgb).to_array().map(compress))
    }

    /// All 0 for colors whose achromatic response is not above 0.
    pub(super) fn to_jmh(self, rgb: DVec3) -> Jmh {
        let response = self.response(rgb);
        if response.x <= 0.0 {
            return Jmh { j: 0.0, m: 0.0, hue: DVec2::X };
        }
        let opponents = DVec2::new(response.y, response.z);
        let hue = opponents.try_normalize().unwrap_or(DVec2::X);
        Jmh { j: REFERENCE * response.x.powf(self.exponent), m: opponents.length(), hue }
    }

    pub(super) fn to_rgb(self, Jmh { j, m, hue }: Jmh) -> DVec3 {
        let response = dvec3(self.achromatic(j), m * hue.x, m * hue.y);
        self.cones_inverse * DVec3::from((self.opponents_inverse * response).to_array().map(expand))
    }

    /// The achromatic response of a lightness.
    pub(super) fn achromatic(&self, j: f64) -> f64 {
        (j / REFERENCE).powf(1.0 / self.exponent)
    }

    /// The luminance in cd/m² of a lightness.
    pub(super) fn luminance(&self, j: f64) -> f64 {
        expand(self.white * self.achromatic(j)) / self.level
    }

    /// The lightness of a luminance in cd/m².
    pub(super) fn lightness(&self, luminance: f64) -> f64 {
        REFERENCE * (compress(luminance * self.level) / self.white).powf(self.exponent)
    }

    /// The factor from luminance in cd/m² to cone responses, and the compressed response to white.
    pub(super) fn scale(&self) -> [f64; 2] {
        [self.level, self.white]
    }

    /// RGB to cone responses, and compressed ones to A, a and b.
    pub(super) fn forward(&self) -> [DMat3; 2] {
        [self.cones, self.opponents]
    }

    /// A, a and b to compressed cone responses, and cone responses to RGB.
    pub(super) fn backward(&self) -> [DMat3; 2] {
        [self.opponents_inverse, self.cones_inverse]
    }
}
