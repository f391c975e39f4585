//! White balance as matrices in double precision, and the color spaces that only nodes use.

use afterimage_graph::color::{self, Chromaticities, Xy};
use afterimage_graph::prelude::*;
use glam::{DMat3, DVec2, DVec3};

use crate::bisection::bisected;

/// Luminance weights of linear Rec.709.
pub const LUMINANCE: DVec3 = DVec3::from_array(color::LUMINANCE_REC709);

/// ARRI Wide Gamut 3 (ARRI, "ALEXA Log C Curve", 2012).
pub const ARRI_WIDE_GAMUT_3: Chromaticities = Chromaticities {
    red: Xy::new(0.6840, 0.3130),
    green: Xy::new(0.2210, 0.8480),
    blue: Xy::new(0.0861, -0.1020),
    white: Xy::D65,
};

/// The luminance weights of linear color in these primaries: those of [`LUMINANCE`] for Rec.709.
pub fn luminance_weights(primaries: &Chromaticities) -> DVec3 {
    if *primaries == Chromaticities::REC709 { LUMINANCE } else { primaries.to_xyz().row(1) }
}

/// AP1 with red moved outwards, after the talk on Ghost of Tsushima. Public notes confirm only the x of red.
pub const TSUSHIMA: Chromaticities = Chromaticities { red: Xy::new(0.750, 0.270), ..Chromaticities::ACES_CG };

choices! {
    /// The cone responses that chromatic adaptation scales.
    pub enum Cones {
        /// Lam's Bradford transform (1985), the usual choice.
        Bradford,
        /// CAT16 (Li et al. 2017): better for strongly colored lights.
        Cat16,
    }
}

impl Cones {
    fn adaptation(self, source: DVec3, destination: DVec3) -> DMat3 {
        let cones = match self {
            Self::Bradford => color::Cones::Bradford,
            Self::Cat16 => color::Cones::Cat16,
        };
        cones.adaptation(source, destination)
    }
}

fn in_rec709(matrix: DMat3) -> DMat3 {
    let to_xyz = Chromaticities::REC709.to_xyz();
    to_xyz.inverse() * matrix * to_xyz
}

/// Lower limit of the components of a target white. Below it the gains of the cones are too large to be useful.
pub const MIN_TARGET: f32 = 1e-4;

/// The matrix on linear Rec.709 that maps white to `target`. With `keep_luminance`, the target is scaled to the
/// luminance of white.
pub fn white_to(target: [f32; 3], adaptation: Cones, keep_luminance: bool) -> DMat3 {
    let target = DVec3::from(target.map(|x| f64::from(x.max(MIN_TARGET))));
    let target = Chromaticities::REC709.to_xyz() * target;
    let scale = if keep_luminance { 1.0 / target.y } else { 1.0 };
    in_rec709(adaptation.adaptation(Xy::D65.to_xyz(), target * scale))
}

/// The matrix on linear Rec.709 that makes a light of this temperature neutral. `duv` is the distance of the light from
/// the locus in CIE 1960 uv, positive toward green.
pub fn white_from(kelvin: f64, duv: f64, adaptation: Cones) -> DMat3 {
    in_rec709(adaptation.adaptation(xyz(light(kelvin, duv)), Xy::D65.to_xyz()))
}

/// The temperature and the distance from the locus, as [`white_from`] takes them, of the light under which gray has
/// this color in linear Rec.709; `None` if no light within the limits of the temperature has it.
pub fn light_of_gray(color: [f64; 3]) -> Option<(f64, f64)> {
    let seen = Chromaticities::REC709.to_xyz() * DVec3::from(color);
    let sum = seen.element_sum();
    let seen = uv(seen.truncate() / sum);
    if !(sum > 0.0 && seen.is_finite()) {
        return None;
    }
    let ahead = |mired: f64| along(1e6 / mired).dot(seen - uv(on_locus(1e6 / mired)));
    // Equal steps in mired are about equally visible. Where the locus bends, several lights lie across from a color.
    let steps = (40..600).map(f64::from).map(|mired| (mired, mired + 1.0));
    let lights = steps.filter(|(low, high)| (ahead(*low) > 0.0) != (ahead(*high) > 0.0)).map(|(low, high)| {
        let is_before = ahead(low) > 0.0;
        let kelvin = 1e6 / bisected(low, high, |mired| (ahead(mired) > 0.0) == is_before);
        (kelvin, across(kelvin).dot(seen - uv(on_locus(kelvin))))
    });
    lights.min_by(|(_, one), (_, other)| one.abs().total_cmp(&other.abs()))
}

/// The xy of a light: a black body (Kim et al. 2002) up to 3333 K, CIE daylight (CIE 15) from 4000 K, and a smooth
/// blend between. The limits are 1667 K and 25000 K.
fn light(kelvin: f64, duv: f64) -> DVec2 {
    let kelvin = kelvin.clamp(1667.0, 25000.0);
    if duv == 0.0 {
        return on_locus(kelvin);
    }
    xy(uv(on_locus(kelvin)) + duv * across(kelvin))
}

/// The direction of the locus toward higher temperatures, from its slope over 0.1 % of the temperature.
fn along(kelvin: f64) -> DVec2 {
    let (warmer, cooler) = (uv(on_branch(kelvin, kelvin * 0.9995)), uv(on_branch(kelvin, kelvin * 1.0005)));
    (cooler - warmer).normalize()
}

/// The normal of the locus, toward green.
fn across(kelvin: f64) -> DVec2 {
    let along = along(kelvin);
    DVec2::new(along.y, -along.x)
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

/// The share of daylight in a light: a smooth step from 0 at 3333 K (300 mired) to 1 at 4000 K (250 mired), where the
/// formula of daylight begins to be valid.
fn daylight_share(kelvin: f64) -> f64 {
    let t = ((300.0 - 1e6 / kelvin) / 50.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn daylight(kelvin: f64) -> ([f64; 4], [f64; 4]) {
    let x = if kelvin <= 7000.0 { [-4.6070, 2.9678, 0.09911, 0.244063] } else { [-2.0064, 1.9018, 0.24748, 0.237040] };
    (x, [0.0, -3.0, 2.870, -0.275])
}

fn black_body(kelvin: f64) -> ([f64; 4], [f64; 4]) {
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

fn xyz(light: DVec2) -> DVec3 {
    DVec3::new(light.x / light.y, 1.0, (1.0 - light.x - light.y) / light.y)
}

fn uv(xy: DVec2) -> DVec2 {
    DVec2::new(4.0 * xy.x, 6.0 * xy.y) / (12.0 * xy.y - 2.0 * xy.x + 3.0)
}

fn xy(uv: DVec2) -> DVec2 {
    DVec2::new(3.0 * uv.x, 2.0 * uv.y) / (2.0 * uv.x - 8.0 * uv.y + 4.0)
}

/// The rows of a matrix, for three dot products in a shader.
pub fn rows(matrix: DMat3) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).extend(0.0).to_array())
}

#[cfg(test)]
mod tests {
    use afterimage_graph::color::Chromaticities;
    use glam::DVec2;

    use super::{light, light_of_gray, xyz};

    fn seen(xy: DVec2) -> [f64; 3] {
        (0.18 * (Chromaticities::REC709.to_xyz().inverse() * xyz(xy))).to_array()
    }

    #[test]
    fn the_light_of_a_gray_that_is_seen_is_found() {
        for kelvin in [1700.0, 2500.0, 3333.0, 3700.0, 4000.0, 5500.0, 7000.0, 12000.0, 24000.0] {
            for duv in [-0.02, -0.003, 0.0, 0.01, 0.02] {
                let (found, distance) = light_of_gray(seen(light(kelvin, duv))).expect("it is a light");
                let off = light(found, distance).distance(light(kelvin, duv));
                assert!(off < 1e-6, "{kelvin} K, {duv}: {found} K, {distance}, {off:.1e} apart in xy");
            }
        }
        // Published in CIE 15 with their correlated temperatures.
        for (name, x, y, kelvin) in [
            ("A", 0.44757, 0.40745, 2856.0),
            ("D50", 0.34567, 0.35850, 5003.0),
            ("D65", 0.31272, 0.32903, 6504.0),
            ("D75", 0.29902, 0.31485, 7504.0),
        ] {
            let (found, distance) = light_of_gray(seen(DVec2::new(x, y))).expect("it is a light");
            assert!((found / kelvin - 1.0).abs() < 5e-3 && distance.abs() < 5e-4, "{name}: {found} K, {distance}");
        }
        for color in [[0.0; 3], [-1.0, 0.2, 0.1], [f64::NAN; 3], [0.0, 0.0, 1.0]] {
            let found = light_of_gray(color);
            assert!(found.is_none_or(|(_, distance)| distance.abs() > 0.05), "{color:?}: {found:?}");
        }
    }

    /// The largest distance in xy of two lights one kelvin apart.
    fn largest_step(duv: f64) -> f64 {
        (1700..12000)
            .map(|kelvin| light(f64::from(kelvin + 1), duv).distance(light(f64::from(kelvin), duv)))
            .fold(0.0, f64::max)
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
    fn a_light_moves_smoothly_with_its_temperature() {
        // Without a blend it was 0.0073 from 3999 K to 4000 K.
        for duv in [0.0, 0.02, -0.02] {
            let step = largest_step(duv);
            println!("tint {duv}: the largest step of one kelvin is {step:.2e} in xy");
            assert!(step < 2e-4, "{duv}: {step}");
        }
    }
}
