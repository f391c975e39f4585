//! Images in files and in memory.
//!
//! - [`codec`]: bytes to a [`Picture`] and back, without a file system.
//! - [`files`]: named files, layers, numbered sequences, atomic writes.
//!
//! No file can stop the program: headers are checked against [`limits`] before anything is allocated, panics of
//! decoders become errors, and each error says what the user can do.

pub mod codec;
pub mod files;

#[cfg(test)]
mod tests;

pub use codec::{
    CodecError, EncodedPixels, ErrorKind, ExrCompression, ExrOptions, Metadata, Picture, Pixels, PngColour, PngDepth,
    PngOptions, catch_panic, encode_exr, encode_png, limits,
};
pub use files::{FileError, Source, read, sequence, write_atomic, write_exr, write_png};
