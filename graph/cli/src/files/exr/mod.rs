//! OpenEXR in and out. SampleMode goes header → choice of layer → size limits → blocks, and nothing
//! is allocated for pixels before the limits have passed.

mod decode;
mod distrust;
mod read;
mod select;
mod write;

use std::path::Path;

use exr::error::Error;

use super::{FileError, FileErrorKind};

pub(crate) use read::read;
pub use write::{ExrCompression, ExrOptions, encode_exr, write_exr};

/// The first four bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = exr::meta::magic_number::BYTES;

/// Puts an error of the decoder into the user's words.
fn explain(path: &Path, error: &Error) -> FileError {
    match error {
        Error::Io(error) => FileError::reading(path, error),
        Error::Invalid(what) if what.contains("missing bytes") => FileError::cut_short(path),
        Error::Invalid(what) if what.contains("channel sampling factor") => subsampled(path),
        Error::NotSupported(what) if what.contains("subsampling") => subsampled(path),
        Error::NotSupported(what) if what.contains("deep") => deep(path),
        Error::NotSupported(what) => unsupported(path, format!("this EXR cannot be read: {what}"))
            .hint("save it again as a flat, ZIP-compressed OpenEXR 2 file"),
        Error::Invalid(what) => FileError::broken(path, what),
        Error::Aborted => FileError::broken(path, error),
    }
}

fn unsupported(path: &Path, what: impl Into<String>) -> FileError {
    FileError::new(path, FileErrorKind::Unsupported, what)
}

fn deep(path: &Path) -> FileError {
    unsupported(path, "deep EXR (many samples in a pixel) is not supported")
        .hint("flatten it first, for example `oiiotool deep.exr --flatten -o flat.exr`")
}

fn subsampled(path: &Path) -> FileError {
    unsupported(path, "chroma-subsampled EXR (luminance with `RY` and `BY`) is not supported")
        .hint("save it again with full-size `R`, `G` and `B` channels")
}
