//! One case: files in a folder of their own, and the words of a command line.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Result;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Command;

/// The content of a path.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    Bytes(Vec<u8>),
    Folder,
    Pipe,
    Socket,
    Link(&'static str),
    /// A file of that many bytes that takes no space.
    Hole(u64),
}

/// The arguments of the program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Case {
    files: Vec<(OsString, Content)>,
    words: Vec<OsString>,
}

impl Case {
    /// A case with the words of a line.
    pub(crate) fn new(line: &str) -> Self {
        Self { files: Vec::new(), words: line.split(' ').map(OsString::from).collect() }
    }

    pub(crate) fn word(mut self, word: impl Into<OsString>) -> Self {
        self.words.push(word.into());
        self
    }

    pub(crate) fn with(self, path: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.with_content(path, Content::Bytes(bytes.into()))
    }

    pub(crate) fn with_content(mut self, path: impl Into<OsString>, content: Content) -> Self {
        self.files.push((path.into(), content));
        self
    }

    pub(crate) fn words(&self) -> &[OsString] {
        &self.words
    }

    /// Makes its files in an empty folder.
    pub(crate) fn unpack(&self, folder: &Path) -> Result<()> {
        self.files.iter().try_for_each(|(path, content)| make(&folder.join(path), content))
    }
}

fn make(path: &Path, content: &Content) -> Result<()> {
    fs::create_dir_all(path.parent().expect("a file lies in a folder"))?;
    match content {
        Content::Bytes(bytes) => fs::write(path, bytes),
        Content::Folder => fs::create_dir_all(path),
        Content::Pipe => Command::new("mkfifo").arg(path).status().map(drop),
        Content::Socket => UnixListener::bind(path).map(drop),
        Content::Link(to) => symlink(to, path),
        Content::Hole(length) => File::create(path)?.set_len(*length),
    }
}
