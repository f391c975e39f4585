//! Proofs of edits: an edited text says at every tier what it is to say, and is right wherever it was before.

use indexmap::IndexMap;

use super::edits::Edits;
use super::file::Before;
use super::state::{State, Stated};
use super::wires::{MainWires, renamed_key, renamed_wire};
use crate::document::{Document, parse, without_mark};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, quote};

/// New values by their keys, and whether the tier gives the value of before.
pub(super) type NewValues = IndexMap<String, (Stated, bool)>;

/// The tier at which something changes, and the new tier that is to have it, if there is one.
#[derive(Clone, Copy)]
pub(super) struct Tiers<'t> {
    pub(super) changed: Option<&'t str>,
    pub(super) new: Option<&'t str>,
}

/// Difference that an edit makes to what a text states.
pub(super) enum Effect {
    /// These values are others.
    Values(NewValues),
    /// A node is gone, and its readers have other wires.
    Removed(String),
    /// A node has another name.
    Renamed { node: String, name: String },
    /// A node is on or off at the tier alone; `None` if it is what it is elsewhere.
    SwitchedAtTier { node: String, on: Option<bool> },
}

/// An edit that is to be proven.
pub(super) struct Proof<'b, 's, 't> {
    pub(super) before: &'b Before<'s>,
    pub(super) tiers: Tiers<'t>,
    pub(super) effect: Effect,
}

/// A tier, and a key with the value that it is to have there.
type Difference = (Option<String>, String, Stated);

impl Proof<'_, '_, '_> {
    /// The edited text, with overrides in the tiers whose values would change otherwise.
    pub(super) fn proven(&self, state: &State<'_>, mut edits: Edits) -> Result<String, Diagnostics> {
        let text = without_mark(self.before.file.text);
        let mut saved = edits.apply(text);
        let mut document = parse(&state.document.file, &saved)?;
        let mut different = self.differences(&document)?;
        for (tier, key, value) in &different {
            if let (Some(tier), Some(text), false) = (tier, state.text(value), key.starts_with('@')) {
                edits.add_to_tier(state, tier, key, text);
            }
        }
        if !different.is_empty() {
            saved = edits.apply(text);
            document = parse(&state.document.file, &saved)?;
            different = self.differences(&document)?;
        }
        if let Some((_, key, _)) = different.first() {
            let key = quote(key.trim_start_matches('@'));
            let message = format!("{key} cannot be saved: no text is known that gives this value");
            return Err(state.error(Diagnostic::error("not-saved", message).help("write the value by hand")));
        }
        self.check(&document)?;
        Ok(self.before.file.with_mark(saved))
    }

    /// The edited text, if it says at every tier what it is to say without further overrides.
    pub(super) fn text_if_it_holds(&self, edits: &Edits) -> Option<String> {
        let text = edits.apply(without_mark(self.before.file.text));
        let document = parse(&self.before.file.document.file, &text).ok()?;
        let holds = self.differences(&document).is_ok_and(|different| different.is_empty());
        (holds && self.check(&document).is_ok()).then(|| self.before.file.with_mark(text))
    }

    /// At all tiers, the keys whose values a document does not have: the new ones where they apply, and those of
    /// before.
    fn differences(&self, document: &Document) -> Result<Vec<Difference>, Diagnostics> {
        let file = self.before.file;
        let mut different = Vec::new();
        for tier in self.all_tiers()? {
            let is_new = tier.is_some() && tier.as_deref() == self.tiers.new;
            let before = self.before.state(if is_new { self.tiers.changed } else { tier.as_deref() })?;
            let after = file.state(document, tier.as_deref())?;
            for (key, value) in self.expected(&before, tier.as_deref()) {
                if after.settings.get(&key).map(|setting| after.stated(setting)).as_ref() != Some(&value) {
                    different.push((tier.clone(), key, value));
                }
            }
        }
        Ok(different)
    }

    /// The tiers that the edited text is to have.
    fn all_tiers(&self) -> Result<Vec<Option<String>>, Diagnostics> {
        let mut tiers = self.before.state(None)?.tiers();
        tiers.extend(self.tiers.new.map(|new| Some(new.to_owned())));
        Ok(tiers)
    }

    /// The values that the edited text is to have at a tier at which these were stated before.
    fn expected(&self, before: &State<'_>, tier: Option<&str>) -> IndexMap<String, Stated> {
        let mut expected: IndexMap<String, Stated> =
            before.settings.iter().map(|(key, setting)| (key.clone(), before.stated(setting))).collect();
        match &self.effect {
            Effect::Values(values) => {
                let applied =
                    values.iter().filter(|(key, (_, was_of_tier))| self.applies(before, tier, key, *was_of_tier));
                expected.extend(applied.map(|(key, (value, _))| (key.clone(), value.clone())));
            }
            Effect::Removed(node) => {
                let main = MainWires::of(before, node);
                expected.retain(|key, _| renamed_key(key, node, "").is_none());
                expected.values_mut().for_each(|value| main.replace(value));
            }
            Effect::Renamed { node, name } => {
                let renamed = |(key, value): (String, Stated)| {
                    let value = match value {
                        Stated::Wire(Some(wire)) => Stated::Wire(Some(renamed_wire(&wire, node, name).unwrap_or(wire))),
                        other => other,
                    };
                    (renamed_key(&key, node, name).unwrap_or(key), value)
                };
                expected = expected.into_iter().map(renamed).collect();
            }
            Effect::SwitchedAtTier { node, on } if tier == self.tiers.changed => {
                match on {
                    Some(on) => drop(expected.insert(node.clone(), Stated::Switch(*on))),
                    // It has the value of elsewhere, whatever that is.
                    None => drop(expected.shift_remove(node)),
                }
            }
            Effect::SwitchedAtTier { .. } => {}
        }
        expected
    }

    /// A value that a tier gives changes at that tier alone; any other one where no tier gives its own.
    fn applies(&self, before: &State<'_>, tier: Option<&str>, key: &str, was_of_tier: bool) -> bool {
        match self.tiers.new {
            Some(new) => tier == Some(new),
            None => tier == self.tiers.changed || !was_of_tier && !before.settings[key].is_of_tier,
        }
    }

    /// Checks that a text is right at all tiers at which it was right before. An error that the text had before at the
    /// tier that is saved is shown in that text.
    fn check(&self, document: &Document) -> Result<(), Diagnostics> {
        let file = self.before.file;
        for tier in self.all_tiers()? {
            let Err(errors) = file.check(document, tier.as_deref()) else { continue };
            let is_new = tier.is_some() && tier.as_deref() == self.tiers.new;
            let tier = if is_new { self.tiers.changed } else { tier.as_deref() };
            match (self.before.errors(tier), tier) {
                (Some(errors), _) if tier == self.tiers.changed => return Err(errors),
                (None, Some(other)) if tier != self.tiers.changed => return Err(wrong_tier(document, other, errors)),
                (None, _) => return Err(errors),
                (Some(_), _) => {}
            }
        }
        Ok(())
    }
}

/// The errors of a tier that a change for all tiers makes wrong.
fn wrong_tier(saved: &Document, tier: &str, errors: Diagnostics) -> Diagnostics {
    let message = format!("the change cannot be saved: at the tier {} it is wrong", quote(tier));
    let named = saved.tiers.iter().find(|(name, _)| name.value == tier);
    let location = named.map_or(&saved.location, |(name, _)| &name.location);
    let mut all = Diagnostics::new(errors.sources.clone());
    all.push(Diagnostic::error("wrong-at-tier", message).at(location, "").help("change the value of the tier first"));
    all.absorb(errors);
    all
}
