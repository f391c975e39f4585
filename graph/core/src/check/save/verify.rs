//! What a saved text must state: the new values at the tier that is saved, and the former values everywhere else.

use std::collections::HashMap;

use super::resolve::ResolvedChange;
use super::state::{SetTo, State, Subject};
use crate::check::files::Files;
use crate::document::Document;
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, quote};

/// What states are made with.
pub(super) struct Context<'a> {
    pub(super) registry: &'a Registry,
    pub(super) files: Files<'a>,
}

impl Context<'_> {
    /// The state of a document at a tier.
    pub(super) fn state(&self, document: &Document, tier: Option<&str>) -> Result<State<'_>, Diagnostics> {
        State::new(document, self.registry, &self.files, tier)
    }
}

/// What is saved.
pub(super) struct ExpectedGraph<'a> {
    /// The text as it was read.
    pub(super) before: &'a Document,
    /// The tier at which the values change.
    pub(super) tier: Option<&'a str>,
    /// The tier that is to have them, if it is a new one.
    pub(super) new_tier: Option<&'a str>,
    pub(super) changes: &'a [ResolvedChange],
}

impl ExpectedGraph<'_> {
    /// Where a saved document differs from what it must state at a tier: the key, and what it must be set to.
    ///
    /// # Errors
    /// The document has errors, or differs in more than values.
    pub(super) fn differences(
        &self,
        context: &Context<'_>,
        saved: &Document,
        tier: Option<&str>,
    ) -> Result<Vec<(String, SetTo)>, Diagnostics> {
        let is_new = tier.is_some() && tier == self.new_tier;
        let before = context.state(self.before, if is_new { self.tier } else { tier })?;
        let after = context.state(saved, tier)?;
        if !before.others().eq(after.others()) {
            return Err(alone(&after, not_saved("the text")));
        }
        let applying = self.changes.iter().filter(|change| self.applies(change, &before, tier));
        let applying: HashMap<Subject, &SetTo> = applying.map(|change| (change.subject, &change.set_to)).collect();
        let must = |subject: Subject| {
            applying.get(&subject).map_or_else(|| before.set_to(subject), |set_to| (*set_to).clone())
        };
        let subjects = before.subjects().map(|subject| (subject, must(subject)));
        let differ = subjects.filter(|(subject, must)| after.set_to(*subject) != *must);
        Ok(differ.map(|(subject, must)| (before.key(subject), must)).collect())
    }

    /// Whether a change holds at a tier. One of a value that a tier gives holds at that tier alone; any other one holds
    /// where no tier gives a value of its own.
    fn applies(&self, change: &ResolvedChange, before: &State<'_>, tier: Option<&str>) -> bool {
        match self.new_tier {
            Some(new) => tier == Some(new),
            None => tier == self.tier || !change.is_of_tier && !before.is_of_tier(change.subject),
        }
    }
}

/// One error of a state's text.
pub(super) fn alone(state: &State<'_>, error: Diagnostic) -> Diagnostics {
    let mut errors = Diagnostics::new(state.builder.diagnostics.sources.clone());
    errors.push(error.at(&state.document.location, ""));
    errors
}

/// The error of a value that no text was found for.
pub(super) fn not_saved(key: &str) -> Diagnostic {
    Diagnostic::error("not-saved", format!("{} cannot be saved: no text is known that gives this value", quote(key)))
        .help("write the value by hand")
}
