//! JPEG files: read by the steps `segments`, `scan` and `samples`, and written.

pub(crate) mod gain_map;
mod huffman;
mod read;
mod samples;
mod scan;
mod segments;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::JpegRows;
