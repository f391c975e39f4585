//! The file that is saved, and what its text says before its edits.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::state::State;
use crate::check::files::Files;
use crate::check::inherit::UsedFiles;
use crate::check::reports::Reports;
use crate::check::{Graph, Loader, check_with};
use crate::document::{Document, parse, without_mark};
use crate::node::Registry;
use afterimage_base::diagnostic::Diagnostics;

/// A pipeline file whose text has no syntax errors, and the files that it names, each of which is read once.
pub(super) struct SavedFile<'a> {
    pub(super) document: Document,
    pub(super) text: &'a str,
    pub(super) registry: &'a Registry,
    files: Files<'a>,
}

impl<'a> SavedFile<'a> {
    pub(super) fn new(
        file: &str,
        text: &'a str,
        registry: &'a Registry,
        loader: &'a dyn Loader,
    ) -> Result<Self, Diagnostics> {
        let document = parse(file, text)?;
        if document.problems.has_errors() {
            return Err(document.problems);
        }
        Ok(Self { document, text, registry, files: Files::new(loader) })
    }

    pub(super) fn state(&self, document: &Document, tier: Option<&str>) -> Result<State<'_>, Diagnostics> {
        State::new(document, self.registry, &self.files, tier)
    }

    /// Checks a text of this file as [`Checker::check`](crate::check::Checker::check) does.
    pub(super) fn check(&self, document: &Document, tier: Option<&str>) -> Result<Graph, Diagnostics> {
        check_with(document, self.registry, &self.files, (tier, &[])).map(|(graph, _)| graph)
    }

    /// Returns whether the file that this one extends has a node of that name.
    pub(super) fn inherits_node(&self, name: &str) -> bool {
        let others = Document { nodes: Vec::new(), ..self.document.clone() };
        let inherited = UsedFiles::new(&self.files).inherited(&others, &mut Reports::default());
        inherited.nodes.iter().any(|node| node.name.value == name)
    }

    /// A text with the byte order mark that the file begins with.
    pub(super) fn with_mark(&self, text: String) -> String {
        let mark = &self.text[..self.text.len() - without_mark(self.text).len()];
        format!("{mark}{text}")
    }
}

/// A text before its edits, with what is read of it at its tiers.
pub(super) struct Before<'s> {
    pub(super) file: &'s SavedFile<'s>,
    states: RefCell<BTreeMap<Option<String>, Rc<State<'s>>>>,
    /// The errors that it has by itself.
    errors: RefCell<BTreeMap<Option<String>, Option<Diagnostics>>>,
}

impl<'s> Before<'s> {
    pub(super) fn new(file: &'s SavedFile<'s>) -> Self {
        Self { file, states: RefCell::default(), errors: RefCell::default() }
    }

    pub(super) fn state(&self, tier: Option<&str>) -> Result<Rc<State<'s>>, Diagnostics> {
        let tier = tier.map(str::to_owned);
        if let Some(known) = self.states.borrow().get(&tier) {
            return Ok(known.clone());
        }
        let state = Rc::new(self.file.state(&self.file.document, tier.as_deref())?);
        self.states.borrow_mut().insert(tier, state.clone());
        Ok(state)
    }

    /// The errors of the text at a tier, if it has any.
    pub(super) fn errors(&self, tier: Option<&str>) -> Option<Diagnostics> {
        let check = || self.file.check(&self.file.document, tier).err();
        self.errors.borrow_mut().entry(tier.map(str::to_owned)).or_insert_with(check).clone()
    }
}
