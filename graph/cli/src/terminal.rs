//! The only place that writes to the terminal.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "all output of the program is written here")]

use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::sync::Mutex;

use afterimage_media::FileError;

/// The error of standard output.
static OUTPUT_ERROR: Mutex<Option<FileError>> = Mutex::new(None);

/// Prints a result to standard output. A closed pipe is not an error; [`check_output`] returns other errors.
pub(crate) fn say(text: &str) {
    let mut out = anstream::stdout().lock();
    let written = writeln!(out, "{}", text.trim_end_matches('\n')).and_then(|()| out.flush());
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut last) = OUTPUT_ERROR.lock()
    {
        *last = Some(FileError::writing(Path::new("standard output"), &error));
    }
}

/// Returns the error of standard output, if there was one.
pub(crate) fn check_output() -> Result<(), FileError> {
    let error = OUTPUT_ERROR.lock().ok().and_then(|mut error| error.take());
    error.map_or(Ok(()), Err)
}

/// Prints a message that is not a result to standard error.
pub(crate) fn note(text: &str) {
    let mut out = anstream::stderr().lock();
    let _ = writeln!(out, "{}", text.trim_end_matches('\n'));
}
