//! The only place that writes to the terminal.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "this is where the program speaks")]

use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::sync::Mutex;

use crate::failure::Failure;
use afterimage_media::FileError;

/// Why a result did not get where it should.
static UNSAID: Mutex<Option<FileError>> = Mutex::new(None);

/// Prints a result to standard output. A reader that went away is no mistake of ours; what else goes wrong is told by [`all_was_said`].
pub(crate) fn say(text: &str) {
    let mut out = anstream::stdout().lock();
    let written = writeln!(out, "{}", text.trim_end_matches('\n')).and_then(|()| out.flush());
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut unsaid) = UNSAID.lock()
    {
        *unsaid = Some(FileError::writing(Path::new("standard output"), &error));
    }
}

/// Whether every result could be printed.
pub(crate) fn all_was_said() -> Result<(), Failure> {
    let unsaid = UNSAID.lock().ok().and_then(|mut unsaid| unsaid.take());
    unsaid.map_or(Ok(()), |error| Err(error.into()))
}

/// Prints something that is not the result to standard error.
pub(crate) fn note(text: &str) {
    let mut out = anstream::stderr().lock();
    let _ = writeln!(out, "{}", text.trim_end_matches('\n'));
}
