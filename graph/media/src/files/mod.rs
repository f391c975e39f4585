//! Image files: [`read()`] turns a named file into a [`Picture`], [`write_image`] writes one atomically, [`sequence`]
//! turns `shot.####.exr` into the names of its frames.

mod atomic;
mod error;
mod folder;
mod image_file;
mod leftovers;
mod memory;
mod paths;
mod regular;
mod rights;
pub mod run_files;
pub mod sequence;
#[cfg(not(target_family = "wasm"))]
mod watch;

use std::fs::File;
use std::io::{BufReader, Cursor, Read as _, Write as _};
use std::path::{Path, PathBuf};

use atomic::write_encoded;
pub use atomic::{AtomicFile, rewrite, write_atomic, write_new};
pub use error::FileError;
pub use folder::images_in;
pub use image_file::ImageFile;
pub use memory::{default_budget, memory_limit};
pub use paths::{real_output_path, real_path};
pub use regular::{Permit, read_bytes, read_permitted, read_permitted_text, read_text};
#[cfg(not(target_family = "wasm"))]
pub use watch::FileWatch;

use crate::codec::{
    Budget, CameraMatrices, ChannelStatistics, CodecError, Description, Encoding, Image, Picture, ReadOptions,
    check_end, decode, decode_camera, describe, encode_beside, encode_with_notes, exr_left_out, measure,
};

/// One image to read: a file, and optionally a layer or a channel of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// The text after `#`: a layer (`diffuse`), a part, or a channel (`diffuse.R`, `Z`).
    pub layer: Option<String>,
}

impl Source {
    /// A file without a named layer; the decoder chooses the most likely one.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), layer: None }
    }

    /// The file, opened for a decoder.
    pub(crate) fn open(&self) -> Result<BufReader<File>, FileError> {
        if self.path.is_dir() {
            return Err(FileError::folder(&self.path));
        }
        Ok(BufReader::new(regular::open(&self.path)?.0))
    }

    fn layer(&self) -> Option<&str> {
        self.layer.as_deref()
    }

    /// The result of a codec; its error gets the name of this file.
    fn named<T>(&self, result: Result<T, CodecError>) -> Result<T, FileError> {
        result.map_err(|error| FileError::at(&self.path, error.of_name(&self.path)))
    }
}

/// Reads an EXR, Radiance or PNG file within a quarter of the machine's memory. The first bytes decide the format, not
/// the name.
///
/// # Errors
/// See [`read_within`].
pub fn read(source: &Source) -> Result<Picture, FileError> {
    read_within(source, default_budget())
}

/// Reads an EXR, Radiance or PNG file. The header is checked against the budget before the image is decoded; `options`
/// may be that budget alone.
///
/// # Errors
/// See [`FileError`]: a file that does not exist, that this user may not read, or that [`decode`] refuses.
pub fn read_within(source: &Source, options: impl Into<ReadOptions>) -> Result<Picture, FileError> {
    source.named(decode(source.open()?, source.layer(), options))
}

/// Reads an image from standard input, within the bytes of the budget.
///
/// # Errors
/// See [`read_within`].
pub fn read_standard_input(options: impl Into<ReadOptions>) -> Result<Picture, FileError> {
    let (options, path) = (options.into(), Path::new("standard input"));
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().take(options.budget.0).read_to_end(&mut bytes);
    read.map_err(|error| FileError::reading(path, &error))?;
    decode(Cursor::new(bytes), None, options).map_err(|error| FileError::at(path, error))
}

/// Writes an image to standard output. Returns sentences about what is left out.
///
/// # Errors
/// See [`encode`](crate::encode), and what standard output reports.
pub fn write_standard_output<'a>(image: impl Into<Image<'a>>, encoding: &Encoding) -> Result<Vec<String>, FileError> {
    let path = Path::new("standard output");
    let (bytes, notes) = encode_with_notes(image.into(), encoding).map_err(|error| FileError::at(path, error))?;
    let mut out = std::io::stdout().lock();
    out.write_all(&bytes).and_then(|()| out.flush()).map_err(|error| FileError::writing(path, &error))?;
    Ok(notes)
}

/// Reads the camera that an EXR file states.
///
/// # Errors
/// See [`FileError`] and [`decode_camera`].
pub fn read_camera(source: &Source) -> Result<CameraMatrices, FileError> {
    source.named(decode_camera(source.open()?, source.layer()))
}

/// Describes an image file by its headers.
///
/// # Errors
/// See [`FileError`] and [`describe`].
pub fn read_description(source: &Source) -> Result<Description, FileError> {
    source.named(describe(source.open()?, source.layer()))
}

/// The statistics of all channels of a file with this description.
///
/// # Errors
/// See [`FileError`] and [`measure`].
pub fn read_statistics(
    source: &Source,
    description: &Description,
    budget: Budget,
) -> Result<Vec<Vec<ChannelStatistics>>, FileError> {
    source.named(measure(source.open()?, description, budget))
}

/// Decodes a file of an earlier run to its last byte, and returns its description. The file is no input of this run,
/// which may replace it.
///
/// # Errors
/// See [`FileError`], [`describe`] and [`measure`]; and a PNG or a JPEG without an end.
pub fn read_whole(source: &Source, budget: Budget) -> Result<Description, FileError> {
    let open = || regular::open_unlisted(&source.path).map(|(file, _)| BufReader::new(file));
    let description = source.named(describe(open()?, source.layer()))?;
    source.named(measure(open()?, &description, budget))?;
    source.named(check_end(open()?, &description))?;
    Ok(description)
}

/// Writes an image file, atomically. Returns sentences about what is left out.
///
/// # Errors
/// See [`encode`](crate::encode) and [`write_atomic`]; and a file whose header cannot be read back.
pub fn write_image<'a>(
    path: &Path,
    image: impl Into<Image<'a>>,
    encoding: &Encoding,
) -> Result<Vec<String>, FileError> {
    let (bytes, notes) = encode_with_notes(image.into(), encoding).map_err(|error| FileError::at(path, error))?;
    write_encoded(path, &bytes)?;
    Ok(notes)
}

/// Writes an EXR file with the other layers of the file that it was made from, atomically. Returns sentences about what
/// is left out.
///
/// # Errors
/// See [`encode_beside`] and [`write_atomic`].
pub fn write_beside<'a>(
    path: &Path,
    image: impl Into<Image<'a>>,
    encoding: &Encoding,
    original: &Source,
    reading: &ReadOptions,
) -> Result<Vec<String>, FileError> {
    let encoded = encode_beside(image, encoding, original.open()?, original.layer(), reading);
    let (bytes, notes) = original.named(encoded)?;
    write_encoded(path, &bytes)?;
    Ok(notes)
}

/// Sentences about what a file has besides its picture, with the reason why an EXR made from it leaves it out.
///
/// # Errors
/// See [`FileError`] and [`exr_left_out`].
pub fn left_out(original: &Source, why: &str) -> Result<Vec<String>, FileError> {
    original.named(exr_left_out(original.open()?, original.layer(), why))
}
