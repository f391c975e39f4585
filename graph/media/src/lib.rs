//! Image files: [`read()`] turns a named file into a [`Picture`]; [`write_exr`] and [`write_png`]
//! turn pixels into files that are written whole or not at all; [`sequence`] turns
//! `shot.####.exr` into the names of its frames.
//!
//! No file can take the program down: headers are checked against [`limits`] before anything is
//! decoded, and every failure is a [`FileError`] that says what to do.

mod chromaticities;
mod error;
mod exr;
mod panics;
mod hdr;
pub mod limits;
mod picture;
mod png;
pub mod sequence;
mod atomic;

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use chromaticities::{Primaries, REC709};
pub use error::{FileError, FileErrorKind};
pub use exr::{ExrCompression, ExrOptions, encode_exr, write_exr};
pub use panics::catch_panic;
pub use picture::{Metadata, Picture, Pixels};
pub use png::{EncodedPixels, PngColour, PngDepth, PngOptions, encode_png, write_png};
pub use atomic::write_atomic;

/// One image to read: a file, and perhaps a layer or channel of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// What stood after `#`: a layer (`diffuse`), a part, or a channel (`diffuse.R`, `Z`).
    pub layer: Option<String>,
}

impl Source {
    /// A whole file, its most likely layer.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), layer: None }
    }
}

/// Reads an EXR, Radiance or PNG file. The bytes decide the format, not the name.
pub fn read(source: &Source) -> Result<Picture, FileError> {
    let path = &source.path;
    match (Format::of(path)?, source.layer.as_deref()) {
        (Format::Exr, layer) => exr::read(path, layer),
        (Format::Hdr, None) => hdr::read(path),
        (Format::Png, None) => png::read(path),
        (_, Some(layer)) => Err(FileError::new(
            path,
            FileErrorKind::Naming,
            format!("only EXR files have layers, so `#{layer}` means nothing here"),
        )
        .hint("leave out what follows the file's name")),
    }
}

enum Format {
    Exr,
    Hdr,
    Png,
}

impl Format {
    fn of(path: &Path) -> Result<Self, FileError> {
        let start = first_bytes(path)?;
        if start.starts_with(&exr::MAGIC) {
            Ok(Self::Exr)
        } else if start.starts_with(&png::MAGIC) {
            Ok(Self::Png)
        } else if hdr::MAGICS.iter().any(|magic| start.starts_with(magic)) {
            Ok(Self::Hdr)
        } else if start.is_empty() {
            Err(FileError::new(path, FileErrorKind::Broken, "the file is empty"))
        } else {
            Err(unknown_format(path, &start))
        }
    }
}

fn first_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let failed = |error| FileError::reading(path, &error);
    if path.is_dir() {
        return Err(FileError::folder(path));
    }
    if path.metadata().is_ok_and(|meta| !meta.is_file()) {
        return Err(FileError::new(path, FileErrorKind::Unsupported, "this is a pipe or a device, not a file")
            .hint("save the image to a file first: it is read in more than one go"));
    }
    let mut start = Vec::new();
    File::open(path).map_err(failed)?.take(16).read_to_end(&mut start).map_err(failed)?;
    Ok(start)
}

fn unknown_format(path: &Path, start: &[u8]) -> FileError {
    const KNOWN: [(&[u8], &str); 6] = [
        (b"\xff\xd8\xff", "a JPEG"),
        (b"II*\0", "a TIFF"),
        (b"MM\0*", "a TIFF"),
        (b"GIF8", "a GIF"),
        (b"SDPX", "a DPX"),
        (b"XPDS", "a DPX"),
    ];
    let found = KNOWN.iter().find(|(magic, _)| start.starts_with(magic));
    let what = found.map_or("not an image that this program knows", |(_, name)| name);
    FileError::new(path, FileErrorKind::Unsupported, format!("this is {what}"))
        .hint("EXR, Radiance HDR and PNG files are read; convert it to one of them")
}
