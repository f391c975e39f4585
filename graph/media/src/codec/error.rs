//! Errors of encoding and decoding.

use std::fmt;
use std::io;

use afterimage_base::diagnostic::shown;

use crate::codec::catch_panic;
use crate::codec::metered::Unfinished;

/// Error of decoding or encoding, with a hint for the user. Both are of one line: names of layers and of
/// channels have escapes for control characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodecError {
    /// The class of the error.
    pub kind: ErrorKind,
    /// One sentence without a full stop.
    pub message: String,
    /// A hint for the user.
    pub hint: Option<String>,
}

/// Classes of errors. All but [`ErrorKind::Machine`] are errors of the user's input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// There is no such file, folder, frame or layer.
    Missing,
    /// The file exists, but it is not a file that this user may read.
    Unreadable,
    /// A well-formed file that uses a feature that is not supported.
    Unsupported,
    /// The content is contradictory or truncated.
    Broken,
    /// The image exceeds [`limits`](crate::limits) or the available memory.
    TooLarge,
    /// The name or the pattern is not valid here.
    Naming,
    /// An error of the machine: a full disk, no permission to write, a failing device.
    Machine,
}

impl CodecError {
    pub(crate) fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self { kind, message: shown(&message.into()).into_owned(), hint: None }
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(shown(&hint.into()).into_owned());
        self
    }

    pub(crate) fn reading(error: &io::Error) -> Self {
        if error.get_ref().is_some_and(|cause| cause.is::<Unfinished>()) {
            return Self::new(ErrorKind::Broken, "the file is unfinished: blocks of the image are missing")
                .hint("it is still being written, or its writer was stopped; render it again");
        }
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::cut_short(),
            io::ErrorKind::FileTooLarge => Self::broken("its header is too long"),
            // A seek to a negative position.
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => Self::broken("it points outside itself"),
            _ => Self::new(ErrorKind::Machine, format!("reading failed: {error}")),
        }
    }

    pub(crate) fn writing(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                Self::new(ErrorKind::Machine, "the disk is full").hint("make room; no file was left half written")
            }
            // Of the file system, or of the process.
            io::ErrorKind::FileTooLarge => Self::new(ErrorKind::Machine, "the file may not become so large")
                .hint("this process may write no larger files (`ulimit -f`)"),
            _ => Self::new(ErrorKind::Machine, format!("writing failed: {error}")),
        }
    }

    pub(crate) fn cut_short() -> Self {
        Self::new(ErrorKind::Broken, "the file ends too early")
            .hint("it was cut short or is still being written; copy or render it again")
    }

    pub(crate) fn broken(what: impl fmt::Display) -> Self {
        Self::new(ErrorKind::Broken, format!("the file is damaged: {what}")).hint("copy or render it again")
    }
}

/// Runs code of a decoder. A panic of it is an error of the file.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> Result<T, CodecError>) -> Result<T, CodecError> {
    catch_panic(decode).unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

impl fmt::Display for CodecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for CodecError {}
