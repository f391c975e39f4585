//! Gamut compression of ACES 1.3, and the tone mapping between displays of BT.2390.

use super::color::{AP1, REC709, conversion};
use super::math::{Rgb, largest, transform};
use super::oklab::{from_oklab, oklab};
use super::transfer::{pq_decode, pq_encode};

/// The reference gamut compression (LMT.Academy.ReferenceGamutCompress) of linear Rec.709.
pub(crate) fn reference_compress(rgb: Rgb) -> Rgb {
    let v = transform(&conversion(&REC709, &AP1), rgb);
    let achromatic = largest(v);
    if achromatic == 0.0 {
        return [0.0; 3];
    }
    let (threshold, limit, power): ([f64; 3], [f64; 3], f64) = ([0.815, 0.803, 0.880], [1.147, 1.264, 1.312], 1.2);
    let compressed = [0, 1, 2].map(|channel| {
        let distance = (achromatic - v[channel]) / achromatic.abs();
        let (thr, lim) = (threshold[channel], limit[channel]);
        if distance < thr {
            return v[channel];
        }
        let scale = (lim - thr) / (((1.0 - thr) / (lim - thr)).powf(-power) - 1.0).powf(1.0 / power);
        let over = (distance - thr) / scale;
        achromatic - (thr + scale * over / (1.0 + over.powf(power)).powf(1.0 / power)) * achromatic.abs()
    });
    transform(&conversion(&AP1, &REC709), compressed)
}

/// Displays of BT.2390's transfer function, in cd/m2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eetf {
    pub(crate) source_peak: f64,
    pub(crate) peak: f64,
    pub(crate) black: f64,
}

impl Eetf {
    /// cd/m2 to cd/m2 (ITU-R BT.2390, section 5.4.1, for a source whose black is 0).
    pub(crate) fn apply(&self, nits: f64) -> f64 {
        let (low, range) = (pq_encode(0.0), pq_encode(self.source_peak) - pq_encode(0.0));
        let share = |nits: f64| (pq_encode(nits) - low) / range;
        let (e1, min_lum, max_lum) =
            (share(nits.clamp(0.0, self.source_peak)), share(self.black), share(self.peak.min(self.source_peak)));
        let ks = 1.5 * max_lum - 0.5;
        let e2 = if e1 < ks || ks >= 1.0 {
            e1
        } else {
            let t = (e1 - ks) / (1.0 - ks);
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * ks + (t3 - 2.0 * t2 + t) * (1.0 - ks) + (3.0 * t2 - 2.0 * t3) * max_lum
        };
        // The lift of black reaches a little beyond the peak of a display with little contrast.
        let e3 = (e2 + min_lum * (1.0 - e2).powi(4)).min(max_lum);
        pq_decode(low + range * e3)
    }

    /// On the largest channel: all channels are scaled alike, and a lifted black adds gray.
    pub(crate) fn on_largest(&self, nits: Rgb) -> Rgb {
        let most = largest(nits);
        let shown = self.apply(most);
        let scale = if most > 0.0 { shown.min(most) / most } else { 0.0 };
        nits.map(|x| scale * x + (shown - most).max(0.0))
    }

    /// On the largest and the smallest channel of linear Rec.709: the hue of Oklab stays, and the chroma in units of the
    /// lightness keeps as much as the saturation of HSV does between the two.
    pub(crate) fn on_extremes(&self, nits: Rgb) -> Rgb {
        let (most, least) = (largest(nits), -largest(nits.map(|x| -x)));
        let shown = self.apply(most);
        if most == least {
            return [shown; 3];
        }
        let kept = (1.0 - self.apply(least) / shown) / (1.0 - least / most);
        let [lightness, a, b] = oklab(nits);
        let paler = from_oklab([lightness, kept * a, kept * b]).map(|x| x.max(0.0));
        paler.map(|x| x * shown / largest(paler))
    }
}

#[test]
fn light_below_the_knee_stays_and_the_peak_becomes_the_peak() {
    let eetf = Eetf { source_peak: 4000.0, peak: 600.0, black: 0.0 };
    for nits in [0.0, 1.0, 40.0, 100.0] {
        assert!((eetf.apply(nits) - nits).abs() < 1e-6 * (1.0 + nits), "{nits}");
    }
    assert!((eetf.apply(4000.0) - 600.0).abs() < 1e-6, "{}", eetf.apply(4000.0));
    assert!(eetf.apply(1000.0) < 560.0 && eetf.apply(1000.0) > 300.0, "{}", eetf.apply(1000.0));
    let lifted = Eetf { black: 0.05, ..eetf };
    assert!((lifted.apply(0.0) - 0.05).abs() < 1e-9 && lifted.apply(4000.0) < 600.0 + 1e-6);
}

/// Values of OpenColorIO 2.6.0 (`ACES-LMT - ACES 1.3 Reference Gamut Compression`) for linear Rec.709.
#[test]
fn the_compression_agrees_with_opencolorio() {
    let text = include_str!("../vectors/gamut_compress.txt");
    let mut count = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let numbers: Vec<f64> = line.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let [r, g, b, wanted @ ..] = &numbers[..] else { panic!("{line}") };
        let found = reference_compress([*r, *g, *b]);
        let scale = 1e-5 * (1.0 + largest([r.abs(), g.abs(), b.abs()]));
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < scale, "{line}: {found}");
        }
        count += 1;
    }
    assert_eq!(count, 60);
}
