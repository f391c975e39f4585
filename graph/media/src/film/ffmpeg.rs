//! The programs `ffmpeg` and `ffprobe`.

use std::ffi::OsStr;
use std::io::{ErrorKind as IoErrorKind, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::{Builder, JoinHandle};

use crate::codec::ErrorKind;
use crate::files::FileError;

/// Films can be lists of others: nothing is read from a network.
pub(super) const FILES_ONLY: [&str; 2] = ["-protocol_whitelist", "file"];

/// The most bytes of messages that are kept.
const MOST_MESSAGES: u64 = 1 << 16;

/// A run of `ffmpeg` on the film `path`, with a thread that reads its messages. It is ended when dropped.
pub(super) struct Process {
    pub(super) child: Child,
    path: std::path::PathBuf,
    messages: Option<JoinHandle<String>>,
}

impl Process {
    /// Starts `ffmpeg` with pipes to its input and from its output.
    pub(super) fn start(path: &Path, arguments: &[impl AsRef<OsStr>]) -> Result<Self, FileError> {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-nostdin", "-y"]).args(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| no_program(path, "ffmpeg", &error))?;
        let errors = child.stderr.take().expect("it is a pipe");
        let messages = Builder::new()
            .spawn(move || read_messages(errors))
            .map_err(|error| FileError::new(path, ErrorKind::Machine, format!("no thread: {error}")))?;
        Ok(Self { child, path: path.into(), messages: Some(messages) })
    }

    /// Waits for the end, after its pipes are closed.
    ///
    /// # Errors
    /// It failed; the error has its first message.
    pub(super) fn finish(&mut self) -> Result<(), FileError> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|error| FileError::reading(&self.path, &error))?;
        let messages = self.messages();
        // Up to version 6 it ends well where it cannot write the end of a file.
        if status.success() && !messages.contains("Error writing") {
            return Ok(());
        }
        Err(refused(&self.path, "ffmpeg", &messages))
    }

    /// The error of a run that ended early.
    pub(super) fn failure(&mut self) -> FileError {
        drop(self.child.stdin.take());
        let _ = self.child.kill();
        let _ = self.child.wait();
        let messages = self.messages();
        refused(&self.path, "ffmpeg", &messages)
    }

    /// All that it has said, after its end.
    fn messages(&mut self) -> String {
        self.messages.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // An error is already on its way to the user.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// All messages are read, so that the program does not wait; the first are kept.
fn read_messages(mut errors: ChildStderr) -> String {
    let mut text = Vec::new();
    let _ = errors.by_ref().take(MOST_MESSAGES).read_to_end(&mut text);
    let _ = std::io::copy(&mut errors, &mut std::io::sink());
    String::from_utf8_lossy(&text).into_owned()
}

/// Refuses to begin a film where there is no `ffmpeg`, which writes it, or no `ffprobe`, which judges it.
///
/// # Errors
/// There is none.
pub fn require(path: &Path) -> Result<(), FileError> {
    ["ffmpeg", "ffprobe"].into_iter().try_for_each(|program| {
        let mut command = Command::new(program);
        command.arg("-version").stdin(Stdio::null());
        command.output().map(drop).map_err(|error| no_program(path, program, &error))
    })
}

/// What `ffprobe` prints about a film.
pub(super) fn probe(path: &Path, arguments: &[&str]) -> Result<String, FileError> {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error"]).args(FILES_ONLY).args(arguments).arg("-i").arg(named(path)).stdin(Stdio::null());
    let output = command.output().map_err(|error| no_program(path, "ffprobe", &error))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(refused(path, "ffprobe", &String::from_utf8_lossy(&output.stderr))),
    }
}

/// The name for `ffmpeg`, which takes a name with a colon for a protocol.
pub(super) fn named(path: &Path) -> std::ffi::OsString {
    let mut name = std::ffi::OsString::from("file:");
    name.push(path);
    name
}

fn no_program(path: &Path, program: &str, error: &std::io::Error) -> FileError {
    let message = match error.kind() {
        IoErrorKind::NotFound => format!("a film needs the program `{program}`, and there is none on the PATH"),
        _ => format!("a film needs the program `{program}`, which does not start: {error}"),
    };
    FileError::new(path, ErrorKind::Machine, message)
        .hint("install `ffmpeg`, from 5.1 on; or use numbered images: `frame.####.png`")
}

/// Errors of writing, as the C library words them.
const OF_WRITING: [(&str, IoErrorKind); 3] = [
    ("No space left on device", IoErrorKind::StorageFull),
    ("Disk quota exceeded", IoErrorKind::QuotaExceeded),
    ("File too large", IoErrorKind::FileTooLarge),
];

fn refused(path: &Path, program: &str, messages: &str) -> FileError {
    if let Some((_, kind)) = OF_WRITING.iter().find(|(words, _)| messages.contains(words)) {
        return FileError::writing(path, &(*kind).into());
    }
    // The last message is often a consequence of the first.
    let first = messages.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("without a message");
    FileError::new(path, ErrorKind::Broken, format!("`{program}` has failed: {first}"))
}
