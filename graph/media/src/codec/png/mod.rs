//! Reads PNG (8 and 16 bits) as linear color and writes it (8 and 16 bits, dithered), with its color chunks.

mod chunks;
mod colors;
mod label;
mod read;
mod strips;
mod write;

pub(crate) use read::{decode, describe};
pub use write::png_codes;
pub(crate) use write::{PngRows, writer_of_image};
