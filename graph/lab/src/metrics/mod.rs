//! Differences between an image and a reference, as people see them.
//!
//! All figures compare pictures as they are shown ([`Shown`]): an SDR picture by its sRGB signal, an HDR picture by
//! its luminance. Where another crate or a published program exists, the tests compare with its figures.

mod ciede2000;
mod color;
mod flip;
mod itp;
mod jod;
mod percentile;
mod plane;
mod psnr;
mod pu21;
mod ssim;

pub use ciede2000::{ciede2000, ciede2000_of};
pub use color::{lab_of_srgb, nits_of_pq, srgb_decode, srgb_encode};
pub use flip::{PIXELS_PER_DEGREE, flip};
pub use itp::{REC2020, delta_e_itp, delta_e_itp_of};
pub use jod::{Display, NO_DIFFERENCE, jod};
pub use percentile::{mean, percentile};
pub use psnr::psnr;
pub use pu21::pu21;
pub use ssim::ssim;

use afterimage_graph::color::rec709_luminance;

/// A picture as a screen shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    pub width: usize,
    pub height: usize,
    /// The meaning of the numbers.
    pub range: Range,
    /// Rows from the top; as long as width times height.
    pub pixels: Vec<[f32; 3]>,
}

/// The meaning of the numbers of a shown picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// The sRGB signal, 0 to 1.
    Sdr,
    /// Linear Rec.709 in cd/m², not negative.
    Hdr,
}

impl Range {
    /// The code that a signal of full strength has: 255 for SDR; 256 for HDR, which PU21 gives to 100 cd/m².
    pub fn peak(self) -> f64 {
        match self {
            Self::Sdr => 255.0,
            Self::Hdr => 256.0,
        }
    }
}

impl Shown {
    /// Codes of about equal visibility: 8-bit codes before rounding for SDR, PU21 of each channel for HDR.
    pub fn codes(&self) -> Vec<[f32; 3]> {
        let code = |x: f32| match self.range {
            Range::Sdr => x * 255.0,
            Range::Hdr => pu21(f64::from(x)) as f32,
        };
        self.pixels.iter().map(|pixel| pixel.map(code)).collect()
    }

    /// The code of each pixel's brightness: luma for SDR, PU21 of luminance for HDR.
    fn brightness(&self) -> Vec<f32> {
        let code = |pixel: &[f32; 3]| match self.range {
            Range::Sdr => rec709_luminance(*pixel) * 255.0,
            Range::Hdr => pu21(f64::from(rec709_luminance(*pixel))) as f32,
        };
        self.pixels.iter().map(code).collect()
    }
}

/// The largest difference of the channels of each pixel, in [codes](Shown::codes).
pub fn difference(reference: &[[f32; 3]], other: &[[f32; 3]]) -> Vec<f32> {
    let largest = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    reference.iter().zip(other).map(largest).collect()
}
