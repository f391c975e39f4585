//! Where the error is, as a picture.

use std::path::Path;

use crate::failure::Failure;
use afterimage_lab::metrics::{Shown, difference};
use afterimage_media::{EncodedPixels, PngOptions, write_png};

/// Codes of error at the ends of the scale, which is logarithmic.
const DARK: f32 = 1.0 / 16.0;
const BRIGHT: f32 = 64.0;

/// The colours of the scale, at even steps from dark to bright: black, indigo, red, orange, yellow, white.
const SCALE: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [58.0, 20.0, 110.0],
    [200.0, 30.0, 60.0],
    [245.0, 125.0, 20.0],
    [252.0, 215.0, 80.0],
    [255.0, 255.0, 255.0],
];

/// Writes the error of each pixel in colours.
pub(crate) fn write_heat(path: &Path, truth: &Shown, shown: &Shown) -> Result<(), Failure> {
    let off = difference(&truth.codes(), &shown.codes());
    let bytes: Vec<u8> = off.into_iter().flat_map(colour).collect();
    let size = (truth.width as u32, truth.height as u32);
    Ok(write_png(path, size, EncodedPixels::Byte(&bytes), &PngOptions { dither: None, ..PngOptions::default() })?)
}

fn colour(codes: f32) -> [u8; 4] {
    let place = (codes.max(DARK) / DARK).log2() / (BRIGHT / DARK).log2();
    let place = place.min(1.0) * (SCALE.len() - 1) as f32;
    let at = (place as usize).min(SCALE.len() - 2);
    let between = place - at as f32;
    let channel = |c: usize| (SCALE[at][c] + (SCALE[at + 1][c] - SCALE[at][c]) * between).round() as u8;
    [channel(0), channel(1), channel(2), 255]
}
