//! Files that a pipeline names, each read and parsed once.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use super::Loader;
use crate::document::{self, Document};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Spanned, quote};

/// The name of the text that `--set` options are shown in.
pub(super) const COMMAND_LINE: &str = "--set";

/// The bytes of a file, or why there are none.
type Bytes = Result<Arc<[u8]>, String>;

/// A pipeline file that another one names.
#[derive(Clone)]
pub(super) enum Named {
    /// A document, with its problems.
    Document(Rc<Document>),
    /// A text that is no pipeline.
    NoPipeline(Diagnostics),
    /// Bytes that are no text.
    NoText,
    /// The file cannot be read; why.
    Unreadable(String),
}

/// Files that have been read.
pub(super) struct Files<'a> {
    loader: &'a dyn Loader,
    bytes: RefCell<BTreeMap<String, Bytes>>,
    overrides: RefCell<BTreeMap<String, Bytes>>,
    documents: RefCell<BTreeMap<String, Named>>,
}

impl<'a> Files<'a> {
    pub(super) fn new(loader: &'a dyn Loader) -> Self {
        Self { loader, bytes: RefCell::default(), overrides: RefCell::default(), documents: RefCell::default() }
    }

    /// The bytes of a file by its joined path.
    pub(super) fn bytes(&self, path: &str) -> Bytes {
        let load = || self.loader.load(path);
        self.bytes.borrow_mut().entry(path.to_owned()).or_insert_with(load).clone()
    }

    /// The bytes of a file that an override names.
    pub(super) fn override_bytes(&self, path: &str) -> Bytes {
        let load = || self.loader.load_override(path);
        self.overrides.borrow_mut().entry(path.to_owned()).or_insert_with(load).clone()
    }

    /// The document in a file by its joined path.
    pub(super) fn document(&self, path: &str) -> Named {
        let read = || self.parsed(path);
        self.documents.borrow_mut().entry(path.to_owned()).or_insert_with(read).clone()
    }

    fn parsed(&self, path: &str) -> Named {
        match self.bytes(path).map(|bytes| String::from_utf8(bytes.to_vec())) {
            Ok(Ok(text)) => match document::parse(path, &text) {
                Ok(document) => Named::Document(Rc::new(document)),
                Err(problems) => Named::NoPipeline(problems),
            },
            Ok(Err(_)) => Named::NoText,
            Err(why) => Named::Unreadable(why),
        }
    }
}

/// A path that is relative to the folder of `from`, joined to it, without `.` and `..` where they can be resolved.
pub(super) fn join(from: &str, path: &str) -> String {
    let is_absolute = path.starts_with(['/', '\\']) || path.get(1..2) == Some(":");
    let folder = if is_absolute { None } else { from.rfind('/').map(|at| &from[..=at]) };
    let joined = format!("{}{path}", folder.unwrap_or_default());
    let mut parts: Vec<&str> = Vec::new();
    for part in joined.split('/') {
        match (part, parts.last()) {
            (".", _) => {}
            ("", Some(_)) => {}
            ("..", Some(&last)) if last != ".." && !last.is_empty() => drop(parts.pop()),
            _ => parts.push(part),
        }
    }
    match parts.join("/") {
        // Its locations would be those of overrides.
        joined if joined == COMMAND_LINE => format!("./{joined}"),
        joined => joined,
    }
}

pub(super) fn unreadable(named: &Spanned<String>, why: &str) -> Diagnostic {
    Diagnostic::error("unreadable-file", format!("cannot read {}: {why}", quote(&named.value)))
        .at(&named.location, "")
        .help("paths are relative to the file that names them")
}

#[cfg(test)]
mod tests {
    use super::join;

    #[test]
    fn a_path_is_joined_to_the_folder_of_the_file_that_names_it() {
        for (from, path, joined) in [
            ("a/b.ron", "c.ron", "a/c.ron"),
            ("b.ron", "c.ron", "c.ron"),
            ("a/b.ron", "./c.ron", "a/c.ron"),
            ("a/b.ron", "d/./c.ron", "a/d/c.ron"),
            ("a/b.ron", "d//c.ron", "a/d/c.ron"),
            ("a/b.ron", "../c.ron", "c.ron"),
            ("a/b.ron", "../../c.ron", "../c.ron"),
            ("../b.ron", "../c.ron", "../../c.ron"),
            ("/a/b.ron", "../../c.ron", "/../c.ron"),
            ("a/b.ron", "/c.ron", "/c.ron"),
            ("a/b.ron", "\\c.ron", "\\c.ron"),
            ("a/b.ron", "c:/d.ron", "c:/d.ron"),
            ("a/b.ron", "cc:/d.ron", "a/cc:/d.ron"),
        ] {
            assert_eq!(join(from, path), joined, "`{path}` in `{from}`");
        }
    }
}
