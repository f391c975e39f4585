//! The error of each pixel as an image.

use std::path::Path;

use afterimage_graph::color::GRAPHICS_WHITE;
use afterimage_media::{Encoding, Samples, write_image};

use crate::LabError;
use crate::metrics::{Range, Shown, difference, srgb_encode};

/// The ends of the logarithmic scale, in codes.
const DARK: f32 = 1.0 / 16.0;
const BRIGHT: f32 = 64.0;

/// The colors of the scale, at even steps from dark to bright: black, indigo, red, orange, yellow, white.
const SCALE: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [58.0, 20.0, 110.0],
    [200.0, 30.0, 60.0],
    [245.0, 125.0, 20.0],
    [252.0, 215.0, 80.0],
    [255.0, 255.0, 255.0],
];

/// Writes a PNG with the error of each pixel in false colors.
pub(crate) fn write(path: &Path, reference: &Shown, shown: &Shown) -> Result<(), LabError> {
    let errors = difference(&reference.codes(), &shown.codes());
    write_bytes(path, reference, &errors.into_iter().flat_map(color).collect::<Vec<u8>>())
}

/// Writes a PNG of what is shown. Of an HDR picture it has what is not brighter than white.
pub(crate) fn write_shown(path: &Path, shown: &Shown) -> Result<(), LabError> {
    let signal = |x: f32| match shown.range {
        Range::Sdr => f64::from(x),
        Range::Hdr => srgb_encode(f64::from(x) / GRAPHICS_WHITE.get()),
    };
    let byte = |x: f32| (255.0 * signal(x)).round() as u8;
    let bytes = shown.pixels.iter().flat_map(|[r, g, b]| [byte(*r), byte(*g), byte(*b), 255]);
    write_bytes(path, shown, &bytes.collect::<Vec<u8>>())
}

fn write_bytes(path: &Path, like: &Shown, bytes: &[u8]) -> Result<(), LabError> {
    let size = (like.width as u32, like.height as u32);
    write_image(path, (size, Samples::Byte(bytes)), &Encoding { dither: None, ..Encoding::PNG })?;
    Ok(())
}

fn color(codes: f32) -> [u8; 4] {
    let place = (codes.max(DARK) / DARK).log2() / (BRIGHT / DARK).log2();
    let place = place.min(1.0) * (SCALE.len() - 1) as f32;
    let at = (place as usize).min(SCALE.len() - 2);
    let between = place - at as f32;
    let channel = |c: usize| (SCALE[at][c] + (SCALE[at + 1][c] - SCALE[at][c]) * between).round() as u8;
    [channel(0), channel(1), channel(2), 255]
}
