//! Reads regular files, of a bounded size. Nothing else in the program opens a file for reading.
//!
//! Names come from strangers: a pipeline, an archive, a folder of kinds. To open a pipe can take forever, to open a
//! device can change its state, and to read one may never end.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use crate::codec::ErrorKind;
use crate::codec::limits::size_of_bytes;
use crate::files::paths::real_path;
use crate::files::{FileError, run_files};

/// Opens a regular file for reading; returns it with its length in bytes. It is an input of the run from then on.
pub(crate) fn open(path: &Path) -> Result<(File, u64), FileError> {
    let (file, length) = open_unlisted(path)?;
    // Where the file is, whatever its name leads to by now.
    run_files::opened(&path_of(&file, path).unwrap_or_else(|_| path.to_owned()));
    Ok((file, length))
}

/// As [`open`], without making the file an input of the run.
pub(super) fn open_unlisted(path: &Path) -> Result<(File, u64), FileError> {
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

/// Opens a regular file that `permit` permits by its path without links: the file that is open, and not one that had
/// the name when it was looked at.
fn open_permitted(path: &Path, permit: Permit<'_>) -> Result<(File, u64), FileError> {
    let permitted = |real: &Path| permit(real).map_err(|why| FileError::new(path, ErrorKind::Unreadable, why));
    let real = real_path(path)?;
    permitted(&real)?;
    let (file, length) = open_unlisted(&real).map_err(|error| FileError { path: path.to_owned(), ..error })?;
    // A link may have taken its place, or that of a folder above it.
    let opened = path_of(&file, &real).map_err(|error| FileError::reading(path, &error))?;
    permitted(&opened)?;
    run_files::opened(&opened);
    Ok((file, length))
}

/// Permits a file to be read, by its path without links, or returns the reason why not.
pub type Permit<'a> = &'a dyn Fn(&Path) -> Result<(), String>;

/// The path of an open file without links; it was opened as `named`.
#[cfg(target_os = "linux")]
fn path_of(file: &File, named: &Path) -> io::Result<PathBuf> {
    use std::os::fd::AsRawFd;
    // Without this file system, names have to do.
    fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd())).or_else(|_| path_by_name(file, named))
}

#[cfg(not(target_os = "linux"))]
fn path_of(file: &File, named: &Path) -> io::Result<PathBuf> {
    path_by_name(file, named)
}

/// The path that the name has, if it still leads to the open file.
fn path_by_name(file: &File, named: &Path) -> io::Result<PathBuf> {
    let real = fs::canonicalize(named)?;
    match is_same(&file.metadata()?, &fs::symlink_metadata(&real)?) {
        true => Ok(real),
        false => Err(io::Error::other("it was replaced while it was read")),
    }
}

#[cfg(unix)]
fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Other systems do not tell files apart.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}

/// Checks that a file can be opened for reading, without opening it.
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

/// Reads a regular file of at most `most` bytes, up to the length that the file system states when it is opened.
///
/// # Errors
/// There is no such file, it is no regular file, it is larger, or it cannot be read.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let (file, length) = open(path)?;
    bytes_of(path, file, length, most)
}

/// The bytes of a regular file that `permit` permits.
///
/// # Errors
/// See [`read_bytes`]; and a file that is not permitted.
pub fn read_permitted(path: &Path, most: u64, permit: Permit<'_>) -> Result<Vec<u8>, FileError> {
    let (file, length) = open_permitted(path, permit)?;
    bytes_of(path, file, length, most)
}

fn bytes_of(path: &Path, file: File, length: u64, most: u64) -> Result<Vec<u8>, FileError> {
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
    text_of(path, read_bytes(path, most)?)
}

/// The text of a regular file that `permit` permits.
///
/// # Errors
/// See [`read_text`] and [`read_permitted`].
pub fn read_permitted_text(path: &Path, most: u64, permit: Permit<'_>) -> Result<String, FileError> {
    text_of(path, read_permitted(path, most, permit)?)
}

fn text_of(path: &Path, bytes: Vec<u8>) -> Result<String, FileError> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|byte| **byte == b'\n').count() + 1;
        FileError::new(path, ErrorKind::Broken, format!("line {line} is not text in UTF-8"))
            .hint("save the file in that encoding")
    })
}
