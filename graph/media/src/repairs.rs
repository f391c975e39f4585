//! The pixels of an input that the graph repairs, and whether it has an alpha.

use afterimage_base::color::rec709_luminance;
use afterimage_base::image::Signedness;
use half::f16;
use rayon::prelude::*;
use serde::Serialize;

use crate::{Picture, Pixels};

/// Numbers of pixels with values that no image can show. Each pixel counts once, for the first that holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Repairs {
    /// With NaN.
    pub nan: u64,
    /// With an infinity.
    pub infinite: u64,
    /// With a negative number that the input does not keep: a luminance below 0 in scene light, any in light of a
    /// display.
    pub negative: u64,
}

impl Repairs {
    /// Counts the pixels of a picture for an input of this signedness.
    pub fn of(picture: &Picture, signedness: Signedness) -> Self {
        Self::below(picture, 0, signedness)
    }

    /// Counts the pixels of a picture from a row on.
    pub fn below(picture: &Picture, row: u32, signedness: Signedness) -> Self {
        let first = row as usize * picture.width as usize;
        match &picture.pixels {
            Pixels::Half(values) => Self::sum(&values[4 * first..], |pixel, repairs| {
                if !pixel.iter().all(needs_no_repair) {
                    repairs.count(pixel.map(f16::to_f32), signedness);
                }
            }),
            Pixels::Float(values) => Self::sum(&values[4 * first..], |pixel, repairs| repairs.count(pixel, signedness)),
        }
    }

    /// The sum of `count` over all pixels, on all cores.
    fn sum<T: Copy + Sync>(values: &[T], count: impl Fn([T; 4], &mut Self) + Sync) -> Self {
        let parts = values.as_chunks::<4>().0.par_chunks(1 << 16).map(|pixels| {
            let mut repairs = Self::default();
            pixels.iter().for_each(|pixel| count(*pixel, &mut repairs));
            repairs
        });
        parts.reduce(Self::default, Self::and)
    }

    fn count(&mut self, pixel: [f32; 4], signedness: Signedness) {
        if pixel.iter().all(|x| x.is_finite() && *x >= 0.0) {
            return;
        }
        if pixel.iter().any(|x| x.is_nan()) {
            self.nan += 1;
        } else if pixel.iter().any(|x| x.is_infinite()) {
            self.infinite += 1;
        } else if is_limited(pixel, signedness) {
            self.negative += 1;
        }
    }

    /// The sum of both.
    pub fn and(self, other: Self) -> Self {
        Self {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
            negative: self.negative + other.negative,
        }
    }

    /// True if no pixel is repaired.
    pub fn is_none(self) -> bool {
        self == Self::default()
    }
}

impl std::fmt::Display for Repairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} NaN, {} infinite, {} negative", self.nan, self.infinite, self.negative)
    }
}

/// True if an input of this signedness does not keep a pixel with a negative number.
fn is_limited([r, g, b, a]: [f32; 4], signedness: Signedness) -> bool {
    match signedness {
        Signedness::Unsigned => true,
        Signedness::Signed => false,
        Signedness::Extended => a < 0.0 || rec709_luminance([r, g, b]) < 0.0,
    }
}

/// True if alpha is 1 everywhere, as in an image without alpha.
pub fn is_opaque(picture: &Picture) -> bool {
    all_pixels(picture, |[.., alpha]| alpha == 1.0)
}

/// True if this holds for all pixels; those after the first for which it does not are not visited.
fn all_pixels(picture: &Picture, mut holds: impl FnMut([f32; 4]) -> bool) -> bool {
    match &picture.pixels {
        Pixels::Half(values) => values.as_chunks::<4>().0.iter().all(|pixel| holds(pixel.map(f16::to_f32))),
        Pixels::Float(values) => values.as_chunks::<4>().0.iter().all(|pixel| holds(*pixel)),
    }
}

/// True if a number is finite and not negative, by its bits; almost all are.
fn needs_no_repair(half: &f16) -> bool {
    half.to_bits() < f16::INFINITY.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_counts_once() {
        let pixels = [
            [1.0, 2.0, 0.0, 1.0],
            [f32::NAN, f32::INFINITY, -1.0, 1.0],
            [f32::NEG_INFINITY, -1.0, 0.0, 1.0],
            [0.9, -0.0, -2.0, 1.0],
            [0.5, 0.5, 0.5, -1.0],
        ];
        let floats = pixels.as_flattened().to_vec();
        let halves = floats.iter().map(|x| f16::from_f32(*x)).collect();
        for pixels in [Pixels::Float(floats), Pixels::Half(halves)] {
            let picture = Picture::new(5, 1, pixels);
            let of = |signedness| Repairs::of(&picture, signedness);
            assert_eq!(of(Signedness::Unsigned), Repairs { nan: 1, infinite: 1, negative: 2 });
            // The blue of -2 is less than the luminance of the red.
            assert_eq!(of(Signedness::Extended), Repairs { nan: 1, infinite: 1, negative: 1 });
            assert_eq!(of(Signedness::Signed), Repairs { nan: 1, infinite: 1, negative: 0 });
            assert!(!is_opaque(&picture));
        }
    }
}
