//! Paths without links, and the files that outputs would replace.

use std::fs::{self, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use crate::codec::ErrorKind;
use crate::files::FileError;

/// The path of an existing file or folder from the root, without links.
///
/// # Errors
/// There is nothing of that name, or a folder of it may not be searched.
pub fn real_path(path: &Path) -> Result<PathBuf, FileError> {
    // An empty path names the current folder.
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    fs::canonicalize(path).map_err(|error| FileError::reading(path, &error))
}

/// Checks that a file can be created or replaced, as far as that is known without writing.
pub(super) fn check_replaceable(path: &Path) -> Result<(), FileError> {
    replaced(path).map(drop)
}

/// The file at the place of an output, if this user may replace it.
pub(super) fn replaced(path: &Path) -> Result<Option<Metadata>, FileError> {
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(FileError::writing(path, &io::ErrorKind::IsADirectory.into())),
        Ok(meta) if meta.is_file() && !may_write(path, &meta)? => {
            Err(FileError::new(path, ErrorKind::Naming, "this file is read-only, and it is not replaced")
                .hint("choose another name, or make it writable"))
        }
        Ok(meta) => Ok(Some(meta)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(FileError::writing(path, &error)),
    }
}

/// True if this user may write a file. Its folder alone decides whether it can be replaced, which its owner may not
/// know, and root may write everything.
fn may_write(path: &Path, meta: &Metadata) -> Result<bool, FileError> {
    if meta.permissions().readonly() {
        return Ok(false);
    }
    let mut options = OpenOptions::new();
    options.write(true);
    // It may be a pipe by now.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    match options.open(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Ok(false),
        // A program that runs.
        Err(error) if error.kind() == io::ErrorKind::ExecutableFileBusy => Ok(true),
        Err(error) => Err(FileError::writing(path, &error)),
    }
}

/// The path from the root, without links, of the file that [`write_atomic`](super::write_atomic) replaces or makes. The
/// file need not exist, also not behind a link.
///
/// # Errors
/// Its folder does not exist or may not be searched, or its links lead in a circle.
pub fn real_output_path(path: &Path) -> Result<PathBuf, FileError> {
    behind_links(path).map_err(|error| FileError::writing(path, &error))
}

fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    loop {
        match fs::canonicalize(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // A circle of links ends here.
            found => return found,
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder)?;
        match fs::read_link(&path) {
            Ok(target) => path = folder.join(target),
            Err(_) => return Ok(folder.join(path.file_name().ok_or(io::ErrorKind::IsADirectory)?)),
        }
    }
}
