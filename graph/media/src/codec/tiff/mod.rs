//! TIFF: strips and tiles of 8 and 16 bits, which hold codes, and of floats, which hold linear color.

mod read;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::{TiffRows, writer_of_image};
