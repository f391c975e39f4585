//! Sharpening: contrast adaptive (Lottes, "FidelityFX CAS", AMD, 2019), and an unsharp mask within the range of the
//! pixels around.

use super::gaussian::{blur_axis, taps};
use super::image::{Image, rgb};
use super::math::{mix, zip};

fn around(image: &Image, x: i64, y: i64, channel: usize) -> [[f64; 3]; 3] {
    [-1, 0, 1].map(|j| [-1, 0, 1].map(|i| image.texel(x + i, y + j)[channel]))
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The channel of a pixel from its square.
fn cas_channel(square: [[f64; 3]; 3], sharpness: f64, white: f64) -> f64 {
    let [[a, b, c], [d, e, f], [g, h, i]] = square;
    let low = least(&[b, d, e, f, h]) + least(&[a, b, c, d, e, f, g, h, i]);
    let high = most(&[b, d, e, f, h]) + most(&[a, b, c, d, e, f, g, h, i]);
    let room = (low.min(2.0 * white - high) / high.max(1e-6)).clamp(0.0, 1.0);
    let weight = -room.sqrt() / mix(8.0, 5.0, sharpness);
    let sharp = (e + weight * (b + d + f + h)) / (1.0 + 4.0 * weight);
    sharp.clamp(0.0, e.max(white))
}

pub(crate) fn cas(image: &Image, sharpness: f64, white: f64, amount: f64) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let (x, y) = (x as i64, y as i64);
        let center = image.texel(x, y);
        let sharp = [0, 1, 2].map(|channel| cas_channel(around(image, x, y, channel), sharpness, white));
        let [r, g, b] = zip(rgb(center), sharp, |a, b| mix(a, b, amount));
        [r, g, b, center[3]]
    })
}

/// The parameters of an unsharp mask.
pub(crate) struct Unsharp {
    pub(crate) amount: f64,
    /// Standard deviation of the blur in pixels.
    pub(crate) sigma: f64,
    pub(crate) threshold: f64,
    pub(crate) halo: f64,
    /// The largest number for a display.
    pub(crate) ceiling: f64,
}

impl Unsharp {
    pub(crate) fn apply(&self, image: &Image) -> Image {
        let half = taps(self.sigma, (3.0 * self.sigma).ceil() as usize);
        let blurred = blur_axis(&blur_axis(image, &half, [1, 0]), &half, [0, 1]);
        Image::new(image.width, image.height, |x, y| {
            let (x, y) = (x as i64, y as i64);
            let [r, g, b] = [0, 1, 2].map(|c| self.channel(around(image, x, y, c), blurred.texel(x, y)[c]));
            [r, g, b, image.texel(x, y)[3]]
        })
    }

    fn channel(&self, square: [[f64; 3]; 3], blurred: f64) -> f64 {
        let (center, all) = (square[1][1], square.concat());
        let (low, high) = (least(&all), most(&all));
        let detail = center - blurred;
        let strong = detail.signum() * (detail.abs() - self.threshold).max(0.0);
        let slack = self.halo * (high - low);
        let floor = (low - slack).max(low.min(0.0));
        let ceiling = (high + slack).min(high.max(self.ceiling));
        (center + self.amount * strong).clamp(floor, ceiling)
    }
}

#[test]
fn contrast_adaptive_sharpening_has_its_published_values() {
    // A pixel of 0.6 among 0.4: low 0.8, high 1.2, so the root of 0.8 / 1.2 is 0.816497; a fifth of it is 0.163299.
    let image = Image::new(3, 3, |x, y| if (x, y) == (1, 1) { [0.6; 4] } else { [0.4; 4] });
    let sharp = cas(&image, 1.0, 1.0, 1.0).texel(1, 1)[0];
    let weight = -(2.0_f64 / 3.0).sqrt() / 5.0;
    assert!((sharp - (0.6 + 4.0 * weight * 0.4) / (1.0 + 4.0 * weight)).abs() < 1e-12);
    assert!((sharp - 0.976_6).abs() < 1e-3, "{sharp}");
    // Black nearby leaves no room.
    let line = Image::new(3, 3, |x, _| [x as f64 * 0.5; 4]);
    assert_eq!(cas(&line, 1.0, 1.0, 1.0), line);
}

#[test]
fn an_unsharp_mask_without_halo_stays_within_its_surroundings() {
    let step = Image::new(9, 1, |x, _| [if x < 4 { 0.25 } else { 0.75 }, x as f64 / 8.0, 0.0, 1.0]);
    let sharp = |halo| Unsharp { amount: 2.0, sigma: 1.0, threshold: 0.0, halo, ceiling: 1.0 }.apply(&step).texel(4, 0);
    assert_eq!(sharp(0.0)[0], 0.75);
    assert!(sharp(0.2)[0] > 0.8 && sharp(0.2)[0] <= 0.75 + 0.2 * 0.5 + 1e-12);
}
