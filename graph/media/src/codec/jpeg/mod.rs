//! JPEG files.

mod read;
mod write;

pub(crate) use read::{MAGIC, decode, describe};
pub use write::{JpegOptions, JpegRows, encode_jpeg};
