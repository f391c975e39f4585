//! Colour spaces, chromatic adaptation and white balance as matrices in double precision.
//!
//! Matrices from primaries follow SMPTE RP 177. They are computed and not typed in, so that every conversion maps white
//! to white without rounding of published digits.

use afterimage_graph::prelude::*;
use glam::{DMat3, DVec2, DVec3};

/// Luminance weights of linear Rec.709, with the four digits of the recommendation. Their sum is exactly 1.
pub(crate) const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The white of sRGB, Rec.709, Display P3 and Rec.2020, as CIE xy.
pub(crate) const D65: DVec2 = DVec2::new(0.3127, 0.3290);

const ACES_WHITE: DVec2 = DVec2::new(0.32168, 0.33767);

/// CIE xy chromaticities of three primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    pub(crate) red: DVec2,
    pub(crate) green: DVec2,
    pub(crate) blue: DVec2,
    pub(crate) white: DVec2,
}

/// ITU-R BT.709, also sRGB: the primaries of the images in a graph.
pub(crate) const REC709: Space = Space {
    red: DVec2::new(0.640, 0.330),
    green: DVec2::new(0.300, 0.600),
    blue: DVec2::new(0.150, 0.060),
    white: D65,
};

/// SMPTE EG 432-1 with D65 white.
pub(crate) const DISPLAY_P3: Space = Space {
    red: DVec2::new(0.680, 0.320),
    green: DVec2::new(0.265, 0.690),
    blue: DVec2::new(0.150, 0.060),
    white: D65,
};

/// ITU-R BT.2020.
pub(crate) const REC2020: Space = Space {
    red: DVec2::new(0.708, 0.292),
    green: DVec2::new(0.170, 0.797),
    blue: DVec2::new(0.131, 0.046),
    white: D65,
};

/// The AP1 primaries of ACEScg (Academy S-2014-004).
pub(crate) const AP1: Space = Space {
    red: DVec2::new(0.713, 0.293),
    green: DVec2::new(0.165, 0.830),
    blue: DVec2::new(0.128, 0.044),
    white: ACES_WHITE,
};

/// AP1 with red moved outwards, after the talk on Ghost of Tsushima. Public notes confirm only the x of red.
pub(crate) const TSUSHIMA: Space = Space { red: DVec2::new(0.750, 0.270), ..AP1 };

impl Space {
    /// Linear RGB to XYZ, with white at Y = 1. Undefined if [`Space::is_usable`] is false.
    fn to_xyz(self) -> DMat3 {
        let primaries = self.primaries();
        primaries * DMat3::from_diagonal(primaries.inverse() * xyz(self.white))
    }

    fn primaries(self) -> DMat3 {
        let column = |p: DVec2| DVec3::new(p.x, p.y, 1.0 - p.x - p.y);
        DMat3::from_cols(column(self.red), column(self.green), column(self.blue))
    }

    /// Whether the primaries span a triangle and white has a positive y.
    pub(crate) fn is_usable(self) -> bool {
        self.primaries().determinant().abs() >= 1e-6 && self.white.y >= 1e-3
    }
}

fn xyz(white: DVec2) -> DVec3 {
    DVec3::new(white.x / white.y, 1.0, (1.0 - white.x - white.y) / white.y)
}

choices! {
    /// The cone responses that chromatic adaptation scales.
    pub enum Cones {
        /// Lam's Bradford transform (1985), the usual choice.
        Bradford,
        /// CAT16 (Li et al. 2017): better for strongly coloured lights.
        Cat16,
    }
}

impl Cones {
    fn cones(self) -> DMat3 {
        let rows = match self {
            Self::Bradford => [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
            Self::Cat16 => {
                [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]]
            }
        };
        DMat3::from_cols_array_2d(&rows).transpose()
    }

    /// The matrix on XYZ that maps the white `source` to the white `destination`.
    fn adapt(self, source: DVec3, destination: DVec3) -> DMat3 {
        let cones = self.cones();
        cones.inverse() * DMat3::from_diagonal((cones * destination) / (cones * source)) * cones
    }
}

/// Maps linear RGB of one space to another. Different whites are adapted by Bradford.
pub(crate) fn conversion(source: Space, destination: Space) -> DMat3 {
    if source == destination {
        return DMat3::IDENTITY;
    }
    let adapt = Cones::Bradford.adapt(xyz(source.white), xyz(destination.white));
    destination.to_xyz().inverse() * adapt * source.to_xyz()
}

fn in_rec709(matrix: DMat3) -> DMat3 {
    let to_xyz = REC709.to_xyz();
    to_xyz.inverse() * matrix * to_xyz
}

/// Lower limit of the components of a target white. Below it the gains of the cones are too large to be useful.
pub(crate) const LEAST_TARGET: f32 = 1e-4;

/// The matrix on linear Rec.709 that maps white to `target`. With `keep_luminance`, the target is scaled to the
/// luminance of white.
pub(crate) fn white_to(target: [f32; 3], adaptation: Cones, keep_luminance: bool) -> DMat3 {
    let target = DVec3::from(target.map(|x| f64::from(x.max(LEAST_TARGET))));
    let target = REC709.to_xyz() * target;
    let scale = if keep_luminance { 1.0 / target.y } else { 1.0 };
    in_rec709(adaptation.adapt(xyz(D65), target * scale))
}

/// The matrix on linear Rec.709 that makes a light of this temperature neutral. `duv` is the distance of the light from
/// the locus in CIE 1960 uv, positive towards green.
pub(crate) fn white_from(kelvin: f64, duv: f64, adaptation: Cones) -> DMat3 {
    in_rec709(adaptation.adapt(xyz(light(kelvin, duv)), xyz(D65)))
}

/// The xy of a light: a black body (Kim et al. 2002) up to 4000 K, CIE daylight (CIE 15) from 5000 K, and a smooth blend
/// between. The limits are 1667 K and 25000 K.
fn light(kelvin: f64, duv: f64) -> DVec2 {
    let kelvin = kelvin.clamp(1667.0, 25000.0);
    if duv == 0.0 {
        return on_locus(kelvin);
    }
    // The normal of the locus, from its slope over 0.1 % of the temperature.
    let (warmer, cooler) = (uv(on_branch(kelvin, kelvin * 0.9995)), uv(on_branch(kelvin, kelvin * 1.0005)));
    let along = (cooler - warmer).normalize();
    xy(uv(on_locus(kelvin)) + duv * DVec2::new(along.y, -along.x))
}

fn on_locus(kelvin: f64) -> DVec2 {
    on_branch(kelvin, kelvin)
}

/// The locus at `kelvin`, by the polynomials that are valid at `branch`. The loci of black bodies and of daylight are
/// 0.007 apart in y, so a light that changes from one to the other must do so gradually.
fn on_branch(branch: f64, kelvin: f64) -> DVec2 {
    let at = |(x, y): ([f64; 4], [f64; 4])| {
        let x = cubic(x, 1000.0 / kelvin);
        DVec2::new(x, cubic(y, x))
    };
    at(black_body(branch)).lerp(at(daylight(branch)), daylight_share(kelvin))
}

/// The share of daylight in a light: a smooth step from 0 at 4000 K (250 mired) to 1 at 5000 K (200 mired).
fn daylight_share(kelvin: f64) -> f64 {
    let t = ((250.0 - 1e6 / kelvin) / 50.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn daylight(kelvin: f64) -> ([f64; 4], [f64; 4]) {
    let x = if kelvin <= 7000.0 { [-4.6070, 2.9678, 0.09911, 0.244063] } else { [-2.0064, 1.9018, 0.24748, 0.237040] };
    (x, [0.0, -3.0, 2.870, -0.275])
}

fn black_body(kelvin: f64) -> ([f64; 4], [f64; 4]) {
    if kelvin > 4000.0 {
        let x = [-3.0258469, 2.1070379, 0.2226347, 0.240390];
        return (x, [3.0817580, -5.87338670, 3.75112997, -0.37001483]);
    }
    let y = if kelvin <= 2222.0 {
        [-1.1063814, -1.34811020, 2.18555832, -0.20219683]
    } else {
        [-0.9549476, -1.37418593, 2.09137015, -0.16748867]
    };
    ([-0.2661239, -0.2343589, 0.8776956, 0.179910], y)
}

fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    ((a * t + b) * t + c) * t + d
}

fn uv(xy: DVec2) -> DVec2 {
    DVec2::new(4.0 * xy.x, 6.0 * xy.y) / (12.0 * xy.y - 2.0 * xy.x + 3.0)
}

fn xy(uv: DVec2) -> DVec2 {
    DVec2::new(3.0 * uv.x, 2.0 * uv.y) / (2.0 * uv.x - 8.0 * uv.y + 4.0)
}

/// The rows of a matrix, for three dot products in a shader.
pub(crate) fn rows(matrix: DMat3) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).extend(0.0).to_array())
}

/// An xy parameter in double precision.
pub(crate) fn chromaticity(xy: [f32; 2]) -> DVec2 {
    // Through the shortest decimal, so that the `f32` 0.3127 becomes the `f64` 0.3127.
    let exact = |x: f32| x.to_string().parse().unwrap_or(f64::from(x));
    DVec2::new(exact(xy[0]), exact(xy[1]))
}

#[cfg(test)]
mod tests {
    use super::light;

    /// The largest distance in xy of two lights one kelvin apart.
    fn largest_step(duv: f64) -> f64 {
        (1700..12000)
            .map(|kelvin| light(f64::from(kelvin + 1), duv).distance(light(f64::from(kelvin), duv)))
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_light_moves_smoothly_with_its_temperature() {
        // 1.3e-4 at the warm end. Without a blend it was 0.0073 from 3999 K to 4000 K.
        for duv in [0.0, 0.02, -0.02] {
            let step = largest_step(duv);
            println!("tint {duv}: the largest step of one kelvin is {step:.2e} in xy");
            assert!(step < 4e-4, "{duv}: {step}");
        }
    }
}
