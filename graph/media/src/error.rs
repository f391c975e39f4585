//! What can go wrong with a file, said to the person who named it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A file that could not be read or written, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// What sort of trouble it is; decides the exit status.
    pub kind: FileErrorKind,
    /// One sentence without a full stop.
    pub message: String,
    /// What the user can do, when that is known.
    pub hint: Option<String>,
}

/// Sorts of trouble. All but [`FileErrorKind::Machine`] are the user's to mend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileErrorKind {
    /// No such file, folder, frame or layer.
    Missing,
    /// It exists, but it is not a file that this user may read.
    Unreadable,
    /// A well-formed file that uses something this program does not read.
    Unsupported,
    /// The bytes contradict themselves or end too early.
    Broken,
    /// Larger than the limits of [`crate::limits`], or than memory allows.
    TooLarge,
    /// The name or pattern itself makes no sense here.
    Naming,
    /// The machine's fault: disk full, no permission to write, a failing device.
    Machine,
}

impl FileError {
    pub(crate) fn new(path: &Path, kind: FileErrorKind, message: impl Into<String>) -> Self {
        Self { path: path.into(), kind, message: message.into(), hint: None }
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The exit status that this error deserves: 1 for the user's input, 2 for the machine.
    pub fn exit(&self) -> u8 {
        if self.kind == FileErrorKind::Machine { 2 } else { 1 }
    }

    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        use FileErrorKind::{Machine, Missing, Unreadable};
        match error.kind() {
            io::ErrorKind::NotFound => Self::new(path, Missing, "there is no such file")
                .hint("check the spelling; names are relative to the folder you are in"),
            io::ErrorKind::PermissionDenied => Self::new(path, Unreadable, "you may not read this file")
                .hint("change its permissions, or copy it to a place of your own"),
            io::ErrorKind::IsADirectory => Self::folder(path),
            io::ErrorKind::UnexpectedEof => Self::cut_short(path),
            // A seek to a negative place.
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => Self::broken(path, "it points outside itself"),
            _ => Self::new(path, Machine, format!("reading failed: {error}")),
        }
    }

    /// The error of an operation that writes `path`.
    pub fn writing(path: &Path, error: &io::Error) -> Self {
        use FileErrorKind::{Machine, Missing, Naming};
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
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                Self::new(path, Machine, "the disk is full").hint("make room; no file was left half written")
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Self::new(path, Machine, "this program may not write here")
                    .hint("choose another folder, or change its permissions")
            }
            _ => Self::new(path, Machine, format!("writing failed: {error}")),
        }
    }

    pub(crate) fn folder(path: &Path) -> Self {
        Self::new(path, FileErrorKind::Unreadable, "this is a folder, not an image")
            .hint("name a file; a sequence in a folder is written `folder/shot.####.exr`")
    }

    pub(crate) fn cut_short(path: &Path) -> Self {
        Self::new(path, FileErrorKind::Broken, "the file ends too early")
            .hint("it was cut short or is still being written; copy or render it again")
    }

    pub(crate) fn broken(path: &Path, what: impl fmt::Display) -> Self {
        Self::new(path, FileErrorKind::Broken, format!("the file is damaged: {what}")).hint("copy or render it again")
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for FileError {}
