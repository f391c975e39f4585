//! The output transform of ACES 2.0 in double precision, after the Academy's reference (the CTL of
//! aces-output): a tone scale on lightness, a compression of chroma, and a compression into the display's gamut.

mod cam;
mod gamut;
mod tables;

use std::sync::{Arc, Mutex, PoisonError};

use afterimage_graph::color::Chromaticities;
use glam::{DMat3, DVec2, DVec3};

use crate::curve_constants::Aces2Tone;

use cam::{Jmh, Model, REFERENCE, lightness_exponent};
use gamut::GamutParams;
use tables::{Hulls, Segment};

/// The compression of chroma: constants that depend on the peak.
#[derive(Clone, Copy, Debug)]
pub struct ChromaParams {
    pub saturation: f64,
    pub threshold: f64,
    pub compression: f64,
    pub scale: f64,
}

impl ChromaParams {
    fn new(peak: f64) -> Self {
        let log_peak = (peak / REFERENCE).log10();
        Self {
            saturation: (1.3 - 1.3 * 0.69 * log_peak).max(0.2),
            threshold: 0.5 / peak,
            compression: 2.4 + 2.4 * 3.3 * log_peak,
            scale: (0.03379 * peak).powf(0.30596) - 0.45135,
        }
    }

    /// A typical M at a hue: a Fourier series with three harmonics.
    fn norm(&self, hue: DVec2) -> f64 {
        let (c, s) = (hue.x, hue.y);
        let (c2, s2) = (2.0 * c * c - 1.0, 2.0 * c * s);
        let (c3, s3) = (4.0 * c * c * c - 3.0 * c, 3.0 * s - 4.0 * s * s * s);
        let cosines = 11.34072 * c + 16.46899 * c2 + 7.88380 * c3;
        let sines = 14.66441 * s - 6.37224 * s2 + 9.19364 * s3;
        self.scale * (cosines + sines + 77.12896)
    }
}

/// A toe that is 0 at 0 and the identity from `limit` on.
fn toe(x: f64, limit: f64, k1: f64, k2: f64) -> f64 {
    if x > limit {
        return x;
    }
    let k2 = k2.max(0.001);
    let k1 = (k1 * k1 + k2 * k2).sqrt();
    let k3 = (limit + k1) / (limit + k2);
    let b = k3 * x - k1;
    0.5 * (b + (b * b + 4.0 * k2 * k3 * x).sqrt())
}

/// The transform for one display.
#[derive(Clone, Debug)]
pub struct OutputTransform {
    top: f64,
    segments: Vec<Segment>,
    brightest: f64,
    tone: Aces2Tone,
    chroma: ChromaParams,
    gamut: GamutParams,
    source: Model,
    display: Model,
    hulls: Hulls,
}

/// Segments of the hulls around all hues.
pub const SEGMENTS: usize = 4096;

/// A display's primaries, and the bits of its peak.
type Display = (Chromaticities, u64);

/// The transforms that were made last. Making one takes a tenth of a second, and every plan needs it.
static MADE: Mutex<Vec<(Display, Arc<OutputTransform>)>> = Mutex::new(Vec::new());

/// The largest number of transforms that are kept.
const KEPT: usize = 8;

impl OutputTransform {
    /// The transform for a display with these primaries and this peak in cd/m². It depends on nothing else, so that it
    /// is made once.
    pub fn of(display: Chromaticities, peak: f64) -> Arc<Self> {
        let key = (display, peak.to_bits());
        let made = || MADE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, transform)) = made().iter().find(|(known, _)| *known == key) {
            return Arc::clone(transform);
        }
        let transform = Arc::new(Self::new(display, peak));
        let mut made = made();
        if made.len() == KEPT {
            made.remove(0);
        }
        made.push((key, Arc::clone(&transform)));
        transform
    }

    fn new(display: Chromaticities, peak: f64) -> Self {
        let (source, reach, display) =
            (Model::new(Chromaticities::ACES_AP0), Model::new(Chromaticities::ACES_CG), Model::new(display));
        let (tone, log_peak) = (Aces2Tone::new(peak), (peak / REFERENCE).log10());
        let gamut = GamutParams {
            limit_j: source.lightness(peak),
            mid_j: source.lightness(REFERENCE * tone.gray),
            focus_distance: 1.35 + 1.35 * 1.75 * log_peak,
            lower_gamma_inv: 1.0 / (1.14 + 0.07 * log_peak),
            model_gamma_inv: 1.0 / lightness_exponent(),
        };
        let brightest = 8.0 * Aces2Tone::hit(peak);
        let hulls = Hulls::new(display, reach, gamut, peak, brightest);
        let segments = hulls.segments(SEGMENTS);
        Self {
            top: peak / REFERENCE,
            segments,
            brightest,
            tone,
            chroma: ChromaParams::new(peak),
            gamut,
            source,
            display,
            hulls,
        }
    }

    /// The value above which AP1 is clipped.
    pub fn brightest(&self) -> f64 {
        self.brightest
    }

    pub fn tone(&self) -> Aces2Tone {
        self.tone
    }

    pub fn chroma(&self) -> ChromaParams {
        self.chroma
    }

    pub fn gamut(&self) -> GamutParams {
        self.gamut
    }

    /// Luminance in cd/m² to cone responses, the compressed response to white, and the exponent from A to J.
    pub fn model(&self) -> [f64; 3] {
        let [level, white] = self.source.scale();
        [level, white, lightness_exponent()]
    }

    /// AP1 to cone responses, compressed ones to A, a and b, back for the display, and cone responses to its RGB.
    pub fn matrices(&self) -> [DMat3; 4] {
        let [cones, opponents] = self.source.forward();
        let [back, display] = self.display.backward();
        [cones * Chromaticities::ACES_CG.conversion(&Chromaticities::ACES_AP0), opponents, back, display]
    }

    /// The hulls around the hues: cusp J, cusp M, the inverse exponent of the upper hull, and the reach of the source.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Linear AP1 to display-linear color, from 0 to the peak, in units of 100 cd/m².
    pub fn apply(&self, ap1: DVec3) -> DVec3 {
        let limited = ap1.clamp(DVec3::ZERO, DVec3::splat(self.brightest));
        let jmh = self.source.to_jmh(Chromaticities::ACES_CG.conversion(&Chromaticities::ACES_AP0) * limited);
        if jmh.j <= 0.0 {
            return DVec3::ZERO;
        }
        let hull = self.hulls.at(jmh.degrees());
        let luminance = REFERENCE * self.tone.apply(self.source.luminance(jmh.j) / REFERENCE);
        let j = self.source.lightness(luminance);
        let m = self.compressed_chroma(jmh, j, hull.reach_m);
        let [j, m] = self.gamut.compress(j, m, &hull);
        let rgb = self.display.to_rgb(Jmh { j, m, ..jmh });
        rgb.clamp(DVec3::ZERO, DVec3::splat(self.top))
    }

    fn compressed_chroma(&self, jmh: Jmh, j: f64, reach_m: f64) -> f64 {
        if jmh.m == 0.0 {
            return 0.0;
        }
        let (norm, share) = (self.chroma.norm(jmh.hue), j / self.gamut.limit_j);
        let rest = (1.0 - share).max(0.0);
        let limit = share.powf(self.gamut.model_gamma_inv) * reach_m / norm;
        let m = jmh.m * (j / jmh.j).powf(self.gamut.model_gamma_inv) / norm;
        let widened = toe(
            limit - m,
            limit - 0.001,
            rest * self.chroma.saturation,
            (share * share + self.chroma.threshold).sqrt(),
        );
        norm * toe(limit - widened, limit, share * self.chroma.compression, rest)
    }
}

#[cfg(test)]
mod tests {
    use super::toe;

    #[test]
    fn the_toe_begins_at_zero_and_meets_the_identity_at_its_limit() {
        for (limit, k1, k2) in [(1.0, 0.4, 0.5), (30.0, 2.0, 0.1), (0.2, 0.0, 0.0)] {
            let toe = |x| toe(x, limit, k1, k2);
            assert!(toe(0.0).abs() < 1e-12 && (toe(limit) - limit).abs() < 1e-12, "{limit}, {k1}, {k2}");
            assert!(toe(0.4 * limit) < toe(0.5 * limit) && toe(0.5 * limit) <= 0.5 * limit, "{limit}, {k1}, {k2}");
        }
    }
}
