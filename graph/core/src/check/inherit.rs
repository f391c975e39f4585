//! Inheritance of documents: `extends` and tiers that are files.

use std::rc::Rc;

use super::build::GraphBuilder;
use super::files::{Named, join, unreadable};
use super::limits::{MAX_DEPTH, MAX_TIERS};
use crate::document::{Document, Tier};
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, did_you_mean, list, quote};

impl GraphBuilder<'_> {
    /// The document of a file that another one names; its problems are reported the first time. `None` where an error
    /// has been reported.
    pub(super) fn document(&mut self, named: &Spanned<String>) -> Option<Rc<Document>> {
        let path = join(&named.location.file, &named.value);
        if !self.has_room_for_text(named) {
            return None;
        }
        let file = self.files.document(&path);
        let is_new = self.files_used.insert(path);
        if let Named::Document(document) = &file {
            if is_new {
                self.diagnostics.absorb(document.problems.clone());
            }
            return Some(document.clone());
        }
        if is_new {
            self.report_no_document(named, file);
        }
        None
    }

    fn report_no_document(&mut self, named: &Spanned<String>, file: Named) {
        match file {
            Named::Document(_) => {}
            Named::NoPipeline(problems) => self.diagnostics.absorb(problems),
            Named::NoText => {
                let message = format!("{} is not a text file", quote(&named.value));
                self.report(Diagnostic::error("unreadable-file", message).at(&named.location, ""));
            }
            Named::Unreadable(why) => self.report(unreadable(named, &why)),
        }
    }

    /// The document with what it inherits.
    pub(super) fn inherited(&mut self, document: &Document) -> Document {
        let mut chain = vec![join("", &document.file)];
        self.inherit(document.clone(), &mut chain)
    }

    fn inherit(&mut self, document: Document, chain: &mut Vec<String>) -> Document {
        let Some(named) = document.extends.clone() else { return document };
        let path = join(&named.location.file, &named.value);
        if chain.contains(&path) || chain.len() >= MAX_DEPTH {
            self.report(extends_itself(&named, &path, chain));
            return Document { is_partial: true, ..document };
        }
        let Some(base) = self.document(&named) else { return Document { is_partial: true, ..document } };
        chain.push(path);
        let base = self.inherit(Rc::unwrap_or_clone(base), chain);
        merge(base, document)
    }

    /// Reports claims of tiers that the document does not have.
    pub(super) fn check_claims(&mut self, document: &Document) {
        for (name, _) in document.claims.iter().take(MAX_TIERS + 1) {
            let is_there = document.tiers.iter().take(MAX_TIERS).any(|(known, _)| known.value == name.value);
            // What could not be read may have it.
            if !is_there && !document.is_partial {
                self.report(unknown_tier(document, &name.value, &name.location));
            }
        }
    }

    /// The document of the requested tier. Its overrides are applied once the nodes are known.
    pub(super) fn tier(&mut self, document: Document, name: Option<&str>) -> Document {
        let Some(name) = name else { return document };
        let Some((_, tier)) = document.tiers.iter().find(|(known, _)| known.value == name) else {
            self.report(unknown_tier(&document, name, &document.location));
            return document;
        };
        match tier {
            Tier::Settings(_) => {
                self.tier = Some(name.to_owned());
                document
            }
            Tier::File(named) => {
                let named = named.clone();
                self.document(&named).map_or(document, |other| self.inherited(&other))
            }
        }
    }
}

fn unknown_tier(document: &Document, name: &str, location: &Location) -> Diagnostic {
    let names = || document.tiers.iter().map(|(name, _)| name.value.as_str());
    let mut help = match document.tiers.len() {
        0 => "it has no tiers at all".to_owned(),
        _ => format!("its tiers are {}", list(names(), 8)),
    };
    if let Some(meant) = did_you_mean(name, names()) {
        help = format!("{meant} {help}");
    }
    Diagnostic::error("unknown-tier", format!("the pipeline has no tier {}", quote(name))).at(location, "").help(help)
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
