//! Images in files and in memory.
//!
//! - [`codec`]: bytes to a [`Picture`] and back, without a file system.
//! - [`files`]: named files, layers, numbered sequences, atomic writes. Everything that the program reads goes
//!   through [`read_bytes`], [`read_text`] and [`files::read`]: regular files of a bounded size. `FileWatch` states
//!   when they change.
//! - `film`: films, by the program `ffmpeg`.
//!
//! No file can stop the program: headers are checked against [`limits`] and a [`Budget`] before anything is allocated,
//! panics of decoders become errors, and each error states what the user can do.
//!
//! The features `avif` and `jxl` read AVIF and JPEG XL.

pub mod codec;
pub mod files;
#[cfg(not(target_family = "wasm"))]
pub mod film;
mod repairs;

#[cfg(test)]
mod tests;

pub use codec::{
    Alpha, Budget, CameraMatrices, ChannelDescription, ChannelStatistics, CodecError, ColorSpace, Description,
    Encoding, ErrorKind, ExrCompression, ForeignFormat, Image, ImageFormat, Metadata, PartDescription, Picture,
    PictureChannels, Pixels, ReadOptions, RowWriter, Samples, Sink, Window, catch_panic, encode, encode_beside,
    exr_left_out, limits, png_codes, row_writer,
};
#[cfg(not(target_family = "wasm"))]
pub use files::FileWatch;
pub use files::{
    AtomicFile, FileError, ImageFile, Permit, Source, default_budget, images_in, left_out, memory_limit, read,
    read_bytes, read_camera, read_description, read_permitted, read_permitted_text, read_standard_input,
    read_statistics, read_text, read_whole, read_within, real_output_path, real_path, rewrite, run_files, sequence,
    write_atomic, write_beside, write_image, write_new, write_standard_output,
};
pub use repairs::{Repairs, is_opaque};
