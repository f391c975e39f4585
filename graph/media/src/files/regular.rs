//! Reads regular files, of a bounded size. Nothing else in the program opens a file for reading.
//!
//! Names come from strangers: a pipeline, an archive, a folder of kinds. To open a pipe can take forever, to open a
//! device can change its state, and to read one may never end.

use std::fs::{File, Metadata, OpenOptions};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::codec::ErrorKind;
use crate::codec::limits::size_of_bytes;
use crate::files::FileError;

/// Opens a regular file for reading; returns it with its length in bytes.
pub(crate) fn open(path: &Path) -> Result<(File, u64), FileError> {
    // An empty path names the current folder.
    if path.as_os_str().is_empty() {
        return Err(folder(path));
    }
    // Before it is opened, because that alone can act on a device.
    refuse_special(path, &path.metadata().map_err(|error| FileError::reading(path, &error))?)?;
    let file = options().open(path).map_err(|error| FileError::reading(path, &error))?;
    // It may be another file by now.
    let meta = file.metadata().map_err(|error| FileError::reading(path, &error))?;
    refuse_special(path, &meta)?;
    Ok((file, meta.len()))
}

/// Looks whether a file can be opened for reading, without opening it.
pub(crate) fn check(path: &Path) -> Result<(), FileError> {
    refuse_special(path, &path.metadata().map_err(|error| FileError::reading(path, &error))?)
}

/// For reading, without waiting for the other end of a pipe.
fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    options
}

fn refuse_special(path: &Path, meta: &Metadata) -> Result<(), FileError> {
    match meta {
        meta if meta.is_file() => Ok(()),
        meta if meta.is_dir() => Err(folder(path)),
        _ => Err(FileError::new(path, ErrorKind::Unreadable, "this is a pipe or a device, not a file")
            .hint("save it to a file first")),
    }
}

fn folder(path: &Path) -> FileError {
    FileError::new(path, ErrorKind::Unreadable, "it is a folder")
}

/// The bytes of a regular file of at most `most` bytes: as many as the file system states before it is read.
///
/// # Errors
/// There is no such file, it is no regular file, it is larger, or it cannot be read.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let (file, length) = open(path)?;
    if length > most {
        let message = format!("the file has {}, and at most {} are read", size_of_bytes(length), size_of_bytes(most));
        return Err(FileError::new(path, ErrorKind::TooLarge, message));
    }
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).map_err(|error| FileError::reading(path, &error))?;
    Ok(bytes)
}

/// The text of a regular file of at most `most` bytes.
///
/// # Errors
/// See [`read_bytes`]; and a file that is not in UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, FileError> {
    String::from_utf8(read_bytes(path, most)?).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|byte| **byte == b'\n').count() + 1;
        FileError::new(path, ErrorKind::Broken, format!("line {line} is not text in UTF-8"))
            .hint("save the file in that encoding")
    })
}

/// The path of an existing file or folder from the root, without links.
///
/// # Errors
/// There is nothing of that name, or a folder of it may not be searched.
pub fn real_path(path: &Path) -> Result<PathBuf, FileError> {
    // An empty path names the current folder.
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    std::fs::canonicalize(path).map_err(|error| FileError::reading(path, &error))
}
