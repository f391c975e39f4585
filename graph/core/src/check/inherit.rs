//! Inheritance of documents: `extends` and tiers that are files.

use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

use super::files::{COMMAND_LINE, Files, Named, join, unreadable};
use super::limits::{MAX_DEPTH, MAX_FILE_BYTES, MAX_TEXT};
use super::reports::Reports;
use crate::document::Document;
use afterimage_base::diagnostic::{Diagnostic, Spanned, quote};

/// Files that a check uses, within the limits of a pipeline.
pub(super) struct UsedFiles<'a> {
    files: &'a Files<'a>,
    /// Paths of the documents whose problems have been reported.
    documents: BTreeSet<String>,
    /// Bytes of the documents, counted at each use.
    text: usize,
    /// Bytes of the files that parameters name, counted at each use.
    bytes: usize,
}

impl<'a> UsedFiles<'a> {
    pub(super) fn new(files: &'a Files<'a>) -> Self {
        Self { files, documents: BTreeSet::new(), text: 0, bytes: 0 }
    }

    /// Returns whether the document at a joined path has been used.
    pub(super) fn has_document(&self, path: &str) -> bool {
        self.documents.contains(path)
    }

    /// The bytes of a file that a parameter names.
    pub(super) fn bytes(&mut self, named: &Spanned<String>) -> Result<Arc<[u8]>, Diagnostic> {
        let joined = join(&named.location.file, &named.value);
        let bytes = match &*named.location.file {
            COMMAND_LINE => self.files.override_bytes(&joined),
            _ => self.files.bytes(&joined),
        };
        let bytes = bytes.map_err(|why| unreadable(named, &why))?;
        self.bytes += bytes.len();
        if self.bytes <= MAX_FILE_BYTES {
            return Ok(bytes);
        }
        let message = format!("the files that the nodes use have more than {MAX_FILE_BYTES} bytes");
        let error = Diagnostic::error("too-large-files", message).at(&named.location, "the first one too many");
        Err(error.help("a file counts as often as it is named: use smaller tables"))
    }

    /// Counts the text of a pipeline file that is used; false if that is too much.
    fn has_room_for_text(&mut self, named: &Spanned<String>, reports: &mut Reports) -> bool {
        let bytes = self.files.bytes(&join(&named.location.file, &named.value)).map_or(0, |bytes| bytes.len());
        self.text += bytes;
        let has_room = self.text <= MAX_TEXT;
        if !has_room {
            let message = format!("the files that the pipeline uses have more than {MAX_TEXT} bytes of text");
            let error = Diagnostic::error("too-much-text", message).at(&named.location, "the first one too many");
            reports.push_limit(error.help("a file counts as often as it is used: use it less often, or shorten it"));
        }
        has_room
    }

    /// The document of a file that another one names; its problems are reported the first time. `None` where an error
    /// has been reported.
    pub(super) fn document(&mut self, named: &Spanned<String>, reports: &mut Reports) -> Option<Rc<Document>> {
        let path = join(&named.location.file, &named.value);
        if !self.has_room_for_text(named, reports) {
            return None;
        }
        let file = self.files.document(&path);
        let is_new = self.documents.insert(path);
        match file {
            Named::Document(document) => {
                if is_new {
                    reports.diagnostics.absorb(document.problems.clone());
                }
                return Some(document);
            }
            _ if !is_new => {}
            Named::NoPipeline(problems) => reports.diagnostics.absorb(problems),
            Named::NoText => {
                let message = format!("{} is not a text file", quote(&named.value));
                reports.push(Diagnostic::error("unreadable-file", message).at(&named.location, ""));
            }
            Named::Unreadable(why) => reports.push(unreadable(named, &why)),
        }
        None
    }

    /// The document with what it inherits.
    pub(super) fn inherited(&mut self, document: &Document, reports: &mut Reports) -> Document {
        let mut chain = vec![join("", &document.file)];
        self.inherit(document.clone(), &mut chain, reports)
    }

    fn inherit(&mut self, document: Document, chain: &mut Vec<String>, reports: &mut Reports) -> Document {
        let Some(named) = document.extends.clone() else { return document };
        let path = join(&named.location.file, &named.value);
        if chain.contains(&path) || chain.len() >= MAX_DEPTH {
            reports.push(extends_itself(&named, &path, chain));
            return Document { is_partial: true, ..document };
        }
        let Some(base) = self.document(&named, reports) else { return Document { is_partial: true, ..document } };
        chain.push(path);
        let base = self.inherit(Rc::unwrap_or_clone(base), chain, reports);
        merge(base, document)
    }
}

fn extends_itself(named: &Spanned<String>, path: &str, chain: &[String]) -> Diagnostic {
    let from = chain.iter().position(|known| known == path);
    let message = match from {
        Some(from) => {
            let names: Vec<&str> = chain[from..].iter().map(String::as_str).chain([path]).collect();
            format!("a file extends itself: {}", names.join(" -> "))
        }
        None => format!("files extend each other more than {MAX_DEPTH} times"),
    };
    Diagnostic::error("extends-cycle", message)
        .at(&named.location, "")
        .help("let the shared part be a file that extends nothing")
}

/// Entries of `base`, replaced by those of `own`.
fn merge(base: Document, own: Document) -> Document {
    let facts = match (base.facts, own.facts) {
        (Some(base), Some(own)) => Some(replace(base, own, |(name, _)| &name.value)),
        (base, own) => own.or(base),
    };
    Document {
        file: own.file,
        location: own.location,
        extends: own.extends,
        inputs: replace(base.inputs, own.inputs, |input| &input.name.value),
        nodes: replace(base.nodes, own.nodes, |node| &node.name.value),
        outputs: replace(base.outputs, own.outputs, |output| &output.name.value),
        set: base.set.into_iter().chain(own.set).collect(),
        tiers: replace(base.tiers, own.tiers, |(name, _)| &name.value),
        // Another file is another pipeline, of which nothing was measured.
        claims: own.claims,
        facts,
        usual: replace(base.usual, own.usual, |(name, _)| &name.value),
        problems: own.problems,
        unread: base.unread.into_iter().chain(own.unread).collect(),
        is_partial: base.is_partial || own.is_partial,
    }
}

/// The base's entries, each replaced by the own one of the same name, and the own ones that are new.
fn replace<T>(base: Vec<T>, own: Vec<T>, name: impl Fn(&T) -> &String) -> Vec<T> {
    let mut all: indexmap::IndexMap<String, T> = base.into_iter().map(|entry| (name(&entry).clone(), entry)).collect();
    all.extend(own.into_iter().map(|entry| (name(&entry).clone(), entry)));
    all.into_values().collect()
}
