//! PNG in (8 and 16 bits, decoded to linear light) and out (8 and 16 bits, dithered), with what the file states about
//! its colors.

mod chunks;
mod label;
mod light;
mod read;
mod strips;
mod write;

pub(crate) use read::{decode, describe};
pub use write::png_codes;
pub(crate) use write::{PngRows, writer_of_image};
