//! Exposure values, the luminance histogram, temporal adaptation and other meters (formula
//! book, 4).

use super::color::level_luminance;
use super::image::{Image, rgb};
use super::math::smooth_step;

/// EV100 of a camera: aperture N, shutter time in seconds, ISO speed (ISO 2720).
pub(crate) fn ev100_camera(aperture: f64, seconds: f64, iso: f64) -> f64 {
    (aperture * aperture / seconds * 100.0 / iso).log2()
}

/// EV100 of a reflected-light meter with K = 12.5, for cd/m².
pub(crate) fn ev100_from_luminance(luminance: f64) -> f64 {
    (luminance * 100.0 / 12.5).log2()
}

/// EV100 of an incident-light meter with C = 250, for lux.
pub(crate) fn ev100_from_illuminance(lux: f64) -> f64 {
    (lux / 2.5).log2()
}

/// The multiplier that puts saturation at 1 (lens factor q = 0.65).
pub(crate) fn multiplier_from_ev100(ev100: f64) -> f64 {
    1.0 / (1.2 * ev100.exp2())
}

/// The stops that bring a metered mean of log2 luminance to `key`, with compensation; limited to
/// ±24.
pub(crate) fn auto_exposure_stops(mean: f64, key: f64, compensation: f64) -> f64 {
    (key.log2() - mean + compensation).clamp(-24.0, 24.0)
}

/// Keeps a metered mean of log2 cd/m² between two limits given as EV100.
pub(crate) fn limit_mean(mean: f64, min_ev100: f64, max_ev100: f64) -> f64 {
    mean.clamp(min_ev100 - 3.0, max_ev100 - 3.0)
}

/// The bins of a luminance histogram; bin 0 holds pixels that the meter does not count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bins {
    pub(crate) count: usize,
    /// The range in log2 of luminance.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Pixels of this luminance or less are not counted.
    pub(crate) black: f64,
}

impl Bins {
    /// The bin of a luminance; NaN goes to bin 0, infinity to the last.
    pub(crate) fn bin(&self, luminance: f64) -> usize {
        if luminance.is_nan() || luminance <= self.black {
            return 0;
        }
        let t = ((luminance.log2() - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        1 + ((t * (self.count - 1) as f64).floor() as usize).min(self.count - 2)
    }

    /// The log2 luminance at the center of bin i ≥ 1.
    pub(crate) fn center(&self, bin: usize) -> f64 {
        self.low + (bin as f64 - 0.5) / (self.count - 1) as f64 * (self.high - self.low)
    }

    /// The histogram of an image, in which each pixel counts 255: those a little brighter than black in part, the rest
    /// of them in bin 0. What is darker still counts 1 in bin 1, all of it in one tile of an image.
    pub(crate) fn histogram(&self, image: &Image) -> Vec<u32> {
        let mut counts = vec![0; self.count];
        for &pixel in &image.pixels {
            self.add(&mut counts, level_luminance(rgb(pixel)));
        }
        let is_faint = |pixel: &[f64; 4]| level_luminance(rgb(*pixel)) > self.black;
        if counts[1..].iter().all(|count| *count == 0) && image.pixels.iter().any(is_faint) {
            counts[0] -= 1;
            counts[1] += 1;
        }
        counts
    }

    /// Adds a pixel of this luminance.
    pub(crate) fn add(&self, counts: &mut [u32], luminance: f64) {
        let share = ((luminance - self.black) / self.black.max(self.low.exp2())).clamp(0.0, 1.0);
        let counted = (255.0 * share * share).round() as u32;
        counts[self.bin(luminance)] += counted;
        counts[0] += 255 - counted;
    }

    /// The mean of log2 luminance around a percentile, with weights 6 x (1 - x) from one end of the window to the other,
    /// which ends where the nearer end of all counted pixels is.
    pub(crate) fn around(&self, counts: &[u32], percentile: f64) -> f64 {
        let total: f64 = counts[1..].iter().map(|&count| f64::from(count)).sum();
        let reach = percentile.min(1.0 - percentile).max(0.005);
        let through = |share: f64| smooth_step(percentile - reach, percentile + reach, share);
        let mut below = 0.0;
        let levels = counts.iter().enumerate().skip(1).map(|(bin, &count)| {
            let from = below / total;
            below += f64::from(count);
            (through(below / total) - through(from)) * self.center(bin)
        });
        levels.sum::<f64>() / (through(1.0) - through(0.0))
    }

    /// The mean of log2 luminance between two percentiles in [0, 1] of the pixels counted; the
    /// quantile when the two are equal or swapped; `None`, to hold, when nothing was counted.
    pub(crate) fn trimmed_mean(&self, counts: &[u32], low: f64, high: f64) -> Option<f64> {
        let total: f64 = counts[1..].iter().map(|&count| f64::from(count)).sum();
        let (a, b) = (low.clamp(0.0, 1.0) * total, high.clamp(0.0, 1.0) * total);
        if total == 0.0 {
            None
        } else if b <= a {
            Some(self.center(quantile_bin(counts, a)))
        } else {
            Some(self.window_sum(counts, a, b) / (b - a))
        }
    }

    /// The sum of bin centers, each as often as its pixels lie in ranks a..b.
    fn window_sum(&self, counts: &[u32], a: f64, b: f64) -> f64 {
        let mut sum = 0.0;
        let mut below: f64 = 0.0;
        for (bin, &count) in counts.iter().enumerate().skip(1) {
            let through = below + f64::from(count);
            sum += (through.clamp(a, b) - below.clamp(a, b)) * self.center(bin);
            below = through;
        }
        sum
    }
}

/// The bin of the pixel with `rank` counted pixels below it, or the last one in use.
fn quantile_bin(counts: &[u32], rank: f64) -> usize {
    let mut through = 0.0;
    let mut last = 1;
    for (bin, &count) in counts.iter().enumerate().skip(1).filter(|(_, count)| **count > 0) {
        through += f64::from(count);
        last = bin;
        if through > rank {
            break;
        }
    }
    last
}

/// Below this distance, in stops, adaptation arrives.
const ARRIVAL: f64 = 1.0 / 1024.0;

/// What an exposure is to become, in stops: it moves in a straight line from what the frame before
/// wanted to what this one does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    pub(crate) before: f64,
    pub(crate) wanted: f64,
}

impl Aim {
    /// One that does not move, as in the formula book.
    pub(crate) fn at(wanted: f64) -> Self {
        Self { before: wanted, wanted }
    }
}

/// Exponential adaptation of `stops` to an aim in `dt` seconds, rates in 1/s: `rate_dark` when the
/// scene got darker and the gain must rise. The solution of e' = r (aim - e) with the aim on its
/// line. Holds when dt is not positive or the aim is not finite; snaps when `stops` is not finite.
pub(crate) fn adapt_exponential(stops: f64, aim: Aim, dt: f64, rate_dark: f64, rate_bright: f64) -> f64 {
    let x = dt * if aim.wanted > stops { rate_dark } else { rate_bright };
    let share = -(-x).exp_m1();
    let of_line = if x > 0.0 { 1.0 - share / x } else { 0.0 };
    adapt(stops, aim, dt, (aim.before - stops) * share + (aim.wanted - aim.before) * of_line)
}

/// Linear adaptation of `stops` to an aim in `dt` seconds, speeds in stops per second. Holds and
/// snaps like [`adapt_exponential`].
pub(crate) fn adapt_linear(stops: f64, aim: Aim, dt: f64, speed_dark: f64, speed_bright: f64) -> f64 {
    if dt.is_nan() || dt <= 0.0 {
        return stops;
    }
    adapt(stops, aim, dt, (aim.wanted - stops).clamp(-speed_bright * dt, speed_dark * dt))
}

fn adapt(stops: f64, aim: Aim, dt: f64, step: f64) -> f64 {
    let Aim { before, wanted } = aim;
    if dt.is_nan() || dt <= 0.0 || !wanted.is_finite() {
        stops
    } else if !stops.is_finite() || (before == wanted && (wanted - stops).abs() < ARRIVAL) {
        wanted
    } else {
        (stops + step).clamp(stops.min(wanted), stops.max(wanted))
    }
}

/// The illuminance in lux that gives a Lambertian surface of `albedo` its luminance.
pub(crate) fn illuminance(luminance: f64, albedo: f64) -> f64 {
    std::f64::consts::PI * luminance / albedo.clamp(0.04, 1.0)
}

/// The luminance that a gray card of 18 % would have in the same light: what the meter counts.
pub(crate) fn gray_card_luminance(luminance: f64, albedo: f64) -> f64 {
    0.18 * illuminance(luminance, albedo) / std::f64::consts::PI
}

/// The mean of log2 luminance over all pixels, none darker than `2^floor`: the top of a pyramid.
pub(crate) fn pyramid_mean(luminances: &[f64], floor: f64) -> f64 {
    let sum: f64 = luminances.iter().map(|y| y.max(floor.exp2()).log2()).sum();
    sum / luminances.len() as f64
}

/// The number of levels of a full mip chain.
pub(crate) fn mip_count(width: usize, height: usize) -> u32 {
    width.max(height).ilog2() + 1
}

#[test]
fn a_histogram_counts_every_pixel_and_meters_the_middle() {
    let bins = Bins { count: 256, low: -10.0, high: 10.0, black: 2.0_f64.powi(-10) };
    let image = Image::new(7, 5, |x, _| match x {
        0 => [f64::NAN, 1.0, 1.0, 1.0],
        1 => [0.0, 0.0, 0.0, 1.0],
        _ => [0.25, 0.25, 0.25, 1.0],
    });
    let counts = bins.histogram(&image);
    assert_eq!(counts.iter().sum::<u32>(), 255 * 35);
    assert_eq!(counts[0], 255 * 10);
    let mean = bins.trimmed_mean(&counts, 0.4, 0.95).expect("some pixels count");
    assert!((mean + 2.0).abs() < 0.501 * 20.0 / 255.0, "{mean}");
}

/// The judge is the definition as an integral over pixels: a parabola of their ranks.
#[test]
fn what_is_around_a_percentile_is_weighted_by_a_parabola() {
    let bins = Bins { count: 256, low: -10.0, high: 10.0, black: 0.0 };
    let lamp = |pixels: usize| {
        let image = Image::new(1000, 1, |x, _| {
            let light = if x >= 1000 - pixels { 512.0 } else { (-6.0 + 6.0 * x as f64 / 1000.0).exp2() };
            [light, light, light, 1.0]
        });
        bins.histogram(&image)
    };
    let parabola = |counts: &[u32], percentile: f64| {
        let total = f64::from(counts[1..].iter().sum::<u32>());
        let reach = percentile.min(1.0 - percentile);
        let (mut sum, mut weights, mut rank) = (0.0, 0.0, 0.5);
        for (bin, count) in counts.iter().enumerate().skip(1) {
            for _ in 0..*count {
                let x = (rank / total - percentile + reach) / (2.0 * reach);
                let weight = if (0.0..1.0).contains(&x) { 6.0 * x * (1.0 - x) } else { 0.0 };
                sum += weight * bins.center(bin);
                weights += weight;
                rank += 1.0;
            }
        }
        sum / weights
    };
    let mut last = bins.around(&lamp(0), 0.95);
    for pixels in 0..=100 {
        let counts = lamp(pixels);
        for percentile in [0.05, 0.3, 0.95].into_iter().filter(|_| pixels % 20 == 7) {
            let off = bins.around(&counts, percentile) - parabola(&counts, percentile);
            assert!(off.abs() < 1e-5, "{pixels} at {percentile}: {off}");
        }
        // A thousandth of the pixels, nine stops brighter, is at most 1.5 % of the weight of a tenth.
        let bright = bins.around(&counts, 0.95);
        assert!(bright - last < 0.015 * 9.5 && bright >= last - 1e-9, "{pixels}: from {last} to {bright}");
        last = bright;
    }
    assert!((last - bins.center(bins.bin(512.0))).abs() < 1e-9, "a tenth is all of the bright part");
    // The ends of a flat picture are one.
    let flat = bins.histogram(&Image::new(9, 9, |_, _| [0.3; 4]));
    for percentile in [0.0, 0.05, 0.5, 0.95, 1.0] {
        assert!((bins.around(&flat, percentile) - bins.center(bins.bin(0.3))).abs() < 1e-12, "{percentile}");
    }
}

#[test]
fn adaptation_snaps_holds_and_never_overshoots() {
    assert_eq!(adapt_exponential(f64::NAN, Aim::at(3.0), 0.1, 1.0, 3.0), 3.0);
    assert_eq!(adapt_exponential(1.0, Aim::at(f64::NAN), 0.1, 1.0, 3.0), 1.0);
    assert_eq!(adapt_exponential(1.0, Aim::at(1.0005), 1e-9, 1.0, 3.0), 1.0005);
    assert_eq!(adapt_linear(-2.0, Aim::at(2.0), f64::INFINITY, 1.0, 3.0), 2.0);
    assert_eq!(limit_mean(20.0, -4.0, 16.0), 13.0);
}

#[test]
fn a_line_followed_in_many_frames_is_the_line_followed_in_one() {
    for (stops, from, to) in [(-1.0, 0.5, 2.0), (3.0, 2.0, -4.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)] {
        let whole = adapt_exponential(stops, Aim { before: from, wanted: to }, 0.25, 1.0, 3.0);
        for count in [2, 6, 1000] {
            let on_line = |index: i32| from + (to - from) * f64::from(index) / f64::from(count);
            let in_parts = (0..count).fold(stops, |stops, index| {
                let aim = Aim { before: on_line(index), wanted: on_line(index + 1) };
                adapt_exponential(stops, aim, 0.25 / f64::from(count), 1.0, 3.0)
            });
            assert!((in_parts - whole).abs() < 1e-12, "{stops} to {from}..{to} in {count}: {in_parts} {whole}");
        }
    }
}

#[test]
fn an_aim_that_turns_back_never_pulls_away_or_past() {
    for (stops, from, to) in [(0.0, 1.0, -0.1), (0.0, -1.0, 0.1), (0.0, 5.0, 0.2), (0.0, -5.0, -0.2), (0.0, 1.0, 0.0)] {
        for dt in [1e-6, 1.0 / 24.0, 1.0, 1e6] {
            let after = adapt_exponential(stops, Aim { before: from, wanted: to }, dt, 1.0, 3.0);
            let share = if to == stops { after } else { (after - stops) / (to - stops) };
            assert!((0.0..=1.0).contains(&share), "{stops} to {from}..{to} in {dt}: {after}");
        }
    }
}

#[test]
fn a_gray_card_meters_as_itself() {
    assert!((gray_card_luminance(0.36, 0.18) - 0.36).abs() < 1e-15);
    assert!((gray_card_luminance(0.36, 0.72) - 0.09).abs() < 1e-15);
}
