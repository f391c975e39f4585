//! PNG in (8 and 16 bits, decoded to linear light) and out (8 and 16 bits, dithered).

mod dither;
mod read;
mod write;

pub(crate) use read::{MAGIC, decode};
pub use write::{EncodedPixels, PngColour, PngDepth, PngOptions, encode_png};

#[cfg(test)]
pub(crate) use dither::dithered as test_dither;
