//! PNG in (8 and 16 bits, decoded to linear light) and out (8 and 16 bits, dithered), with what the file states about
//! its colors.

mod chunks;
mod label;
mod light;
mod read;
mod strips;
mod write;

pub(crate) use read::{MAGIC, decode, describe};
pub use strips::PngDepth;
pub use write::{Alpha, PngOptions, PngRows, encode_png, png_codes, png_left_out};
