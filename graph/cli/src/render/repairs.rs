//! The pixels of an input that the graph repairs, and whether it has an alpha.

use afterimage_media::{Picture, Pixels};
use serde::Serialize;

/// Numbers of pixels with values that no image can show. Each pixel counts once, for the first that holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Repairs {
    /// With a NaN.
    pub(crate) nan: u64,
    /// With an infinity.
    pub(crate) infinite: u64,
    /// With a negative number, where the input holds light.
    pub(crate) negative: u64,
}

impl Repairs {
    /// Counts the pixels of a picture. `signed` is that of the input: negative numbers are then kept.
    pub(crate) fn of(picture: &Picture, signed: bool) -> Self {
        match &picture.pixels {
            Pixels::Half(values) => {
                count(values, signed, |x| Number::of(x.is_nan(), x.is_infinite(), negative(x.to_bits())))
            }
            Pixels::Float(values) => count(values, signed, |x| Number::of(x.is_nan(), x.is_infinite(), *x < 0.0)),
        }
    }

    /// The sum of both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
            negative: self.negative + other.negative,
        }
    }

    /// Whether no pixel is repaired.
    pub(crate) fn is_none(self) -> bool {
        self == Self::default()
    }
}

impl std::fmt::Display for Repairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} NaN, {} infinite, {} negative", self.nan, self.infinite, self.negative)
    }
}

/// Whether the bits are those of a half float below 0.
fn negative(bits: u16) -> bool {
    bits > 0x8000
}

/// What a number of a pixel is; the larger one decides for the pixel.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Number {
    Fine,
    Negative,
    Infinite,
    Nan,
}

impl Number {
    fn of(is_nan: bool, is_infinite: bool, is_negative: bool) -> Self {
        match (is_nan, is_infinite, is_negative) {
            (true, ..) => Self::Nan,
            (_, true, _) => Self::Infinite,
            (.., true) => Self::Negative,
            _ => Self::Fine,
        }
    }
}

fn count<T>(values: &[T], signed: bool, number: impl Fn(&T) -> Number) -> Repairs {
    let mut repairs = Repairs::default();
    for pixel in values.as_chunks::<4>().0 {
        match pixel.iter().map(&number).max() {
            Some(Number::Nan) => repairs.nan += 1,
            Some(Number::Infinite) => repairs.infinite += 1,
            Some(Number::Negative) if !signed => repairs.negative += 1,
            _ => {}
        }
    }
    repairs
}

/// Whether alpha is 1 everywhere, as in an image without alpha.
pub(crate) fn is_opaque(picture: &Picture) -> bool {
    match &picture.pixels {
        Pixels::Half(values) => values.as_chunks::<4>().0.iter().all(|pixel| pixel[3].to_f32() == 1.0),
        Pixels::Float(values) => values.as_chunks::<4>().0.iter().all(|pixel| pixel[3] == 1.0),
    }
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
            [0.5, -0.0, -2.0, 1.0],
            [0.5, 0.5, 0.5, -1.0],
        ];
        let floats = pixels.as_flattened().to_vec();
        let halves = floats.iter().map(|x| half::f16::from_f32(*x)).collect();
        for pixels in [Pixels::Float(floats), Pixels::Half(halves)] {
            let picture = Picture::new(5, 1, pixels);
            assert_eq!(Repairs::of(&picture, false), Repairs { nan: 1, infinite: 1, negative: 2 });
            assert_eq!(Repairs::of(&picture, true), Repairs { nan: 1, infinite: 1, negative: 0 });
            assert!(!is_opaque(&picture));
        }
    }
}
