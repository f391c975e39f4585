//! The luminance of encoded pixels, for the content light level of HDR files.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer, hlg_gamma};
use rayon::prelude::*;

/// Content light level in cd/m2 (CTA-861.3): of the brightest channel of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightLevel {
    /// MaxCLL: of the brightest pixel.
    pub(crate) max: f64,
    /// MaxFALL for a single image: the mean over all pixels.
    pub(crate) mean: f64,
}

impl LightLevel {
    /// The light level of HDR codes; `None` for SDR, and for HLG without a stated peak.
    pub(crate) fn of(codes: &[u16], channels: usize, bits: u32, color: &Colorimetry) -> Option<Self> {
        let nits = Nits::new(bits, color)?;
        // Sums of fixed groups in a fixed order, so that equal codes give equal bytes.
        let groups: Vec<(f32, f64)> =
            codes.par_chunks(channels * 4096).map(|group| nits.group(group, channels)).collect();
        let max = groups.iter().fold(0.0_f32, |max, (group, _)| max.max(*group));
        let sum: f64 = groups.iter().map(|(_, sum)| sum).sum();
        Some(Self { max: max.into(), mean: sum / (codes.len() / channels) as f64 })
    }
}

struct Nits {
    /// The linear value of each code: in cd/m2 for PQ, scene-linear for HLG.
    linear: Vec<f32>,
    /// HLG: luminance weights, the peak and the system gamma less 1.
    display: Option<([f32; 3], f32, f32)>,
}

impl Nits {
    fn new(bits: u32, color: &Colorimetry) -> Option<Self> {
        let (scale, display) = match color.transfer {
            Transfer::Pq => (10000.0, None),
            Transfer::Hlg => (1.0, Some(hlg_display(&color.primaries, color.peak_nits?.get()))),
            Transfer::Linear | Transfer::Srgb | Transfer::Gamma(_) => return None,
        };
        let last = (1_u32 << bits) - 1;
        let linear = |code: u32| (color.transfer.to_light(f64::from(code) / f64::from(last)) * scale) as f32;
        Some(Self { linear: (0..=last).map(linear).collect(), display })
    }

    /// The brightest pixel and the sum of a group of pixels.
    fn group(&self, codes: &[u16], channels: usize) -> (f32, f64) {
        let pixels = codes.chunks_exact(channels).map(|pixel| self.pixel([pixel[0], pixel[1], pixel[2]]));
        pixels.fold((0.0, 0.0), |(max, sum), nits| (nits.max(max), sum + f64::from(nits)))
    }

    fn pixel(&self, codes: [u16; 3]) -> f32 {
        let [r, g, b] = codes.map(|code| self.linear[usize::from(code)]);
        let brightest = r.max(g).max(b);
        match self.display {
            None => brightest,
            Some(([red, green, blue], peak, power)) => {
                let luminance = red * r + green * g + blue * b;
                // Black has no luminance to the power of a negative number.
                if luminance > 0.0 { peak * brightest * luminance.powf(power) } else { 0.0 }
            }
        }
    }
}

fn hlg_display(primaries: &Chromaticities, peak: f64) -> ([f32; 3], f32, f32) {
    let weights = primaries.to_xyz().row(1).as_vec3().to_array();
    (weights, peak as f32, (hlg_gamma(peak) - 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures of several groups; in the second ones the last pixel is the brightest.
    #[test]
    fn the_level_is_that_of_all_pixels_whatever_the_channels() {
        let color = Colorimetry::new(Chromaticities::REC709, Transfer::Pq);
        for channels in [3, 4] {
            let mut codes = [100_u16, 180, 60, 255][..channels].repeat(10_000);
            let level = LightLevel::of(&codes, channels, 8, &color).expect("HDR");
            let nits = |code: f64| color.transfer.to_light(code / 255.0) * 10000.0;
            assert!((level.max / nits(180.0) - 1.0).abs() < 1e-6 && (level.mean / level.max - 1.0).abs() < 1e-6);
            codes[channels * 9_999] = 200;
            let level = LightLevel::of(&codes, channels, 8, &color).expect("HDR");
            assert!((level.max / nits(200.0) - 1.0).abs() < 1e-6, "{level:?}");
        }
        assert_eq!(LightLevel::of(&[0; 3], 3, 8, &Colorimetry::SRGB), None);
    }
}
