//! Errors of files, with the path that the user gave.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use afterimage_base::diagnostic::{shown, shown_path};

use crate::codec::{CodecError, ErrorKind};

/// Error of reading or writing a file, with a hint for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// The class of the error; decides the exit status.
    pub kind: ErrorKind,
    /// One sentence without a full stop.
    pub message: String,
    /// A hint for the user.
    pub hint: Option<String>,
}

impl FileError {
    pub(crate) fn new(path: &Path, kind: ErrorKind, message: impl Into<String>) -> Self {
        Self::at(path, CodecError::new(kind, message))
    }

    /// An error of encoding or decoding the file at `path`.
    pub(crate) fn at(path: &Path, CodecError { kind, message, hint }: CodecError) -> Self {
        Self { path: path.into(), kind, message, hint }
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(shown(&hint.into()).into_owned());
        self
    }

    /// The exit status of the program: 1 for an error of the input, 2 for an error of the machine.
    pub fn exit(&self) -> u8 {
        if self.kind == ErrorKind::Machine { 2 } else { 1 }
    }

    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        use ErrorKind::{Missing, Unreadable};
        match error.kind() {
            io::ErrorKind::NotFound => Self::new(path, Missing, "there is no such file")
                .hint("check the spelling; names are relative to the folder you are in"),
            io::ErrorKind::PermissionDenied => Self::new(path, Unreadable, "you may not read this file")
                .hint("change its permissions, or copy it to a place of your own"),
            io::ErrorKind::IsADirectory => Self::folder(path),
            io::ErrorKind::NotADirectory => Self::new(path, Missing, "a part of this name is a file, not a folder"),
            io::ErrorKind::InvalidFilename | io::ErrorKind::InvalidInput => {
                Self::new(path, Missing, "the file system refuses this name")
            }
            #[cfg(unix)]
            _ if error.raw_os_error() == Some(libc::ELOOP) => Self::new(path, Unreadable, "its links lead in a circle"),
            _ => Self::at(path, CodecError::reading(error)),
        }
    }

    /// The error of an operation that writes `path`.
    pub fn writing(path: &Path, error: &io::Error) -> Self {
        use ErrorKind::{Machine, Missing, Naming};
        match error.kind() {
            io::ErrorKind::NotFound => {
                Self::new(path, Missing, "the folder of this output does not exist").hint("create the folder first")
            }
            io::ErrorKind::IsADirectory => Self::new(path, Naming, "the output is a folder")
                .hint("name a file inside it, ending in `.png` or `.exr`"),
            io::ErrorKind::NotADirectory => Self::new(path, Naming, "a part of this name is a file, not a folder"),
            io::ErrorKind::InvalidFilename | io::ErrorKind::InvalidInput => {
                Self::new(path, Naming, "the file system refuses this name")
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Self::new(path, Machine, "this program may not write here")
                    .hint("choose another folder, or change its permissions")
            }
            #[cfg(unix)]
            _ if error.raw_os_error() == Some(libc::ELOOP) => Self::new(path, Naming, "its links lead in a circle"),
            _ => Self::at(path, CodecError::writing(error)),
        }
    }

    pub(crate) fn folder(path: &Path) -> Self {
        Self::new(path, ErrorKind::Unreadable, "this is a folder, not an image")
            .hint("name a file; a sequence in a folder is written `folder/shot.####.exr`")
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", shown_path(&self.path), self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for FileError {}
