//! From changes to a text that is checked again.

use super::change::Change;
use super::resolve::resolve;
use super::state::{SetTo, State};
use super::verify::{Context, ExpectedGraph, alone, not_saved};
use crate::check::files::Files;
use crate::check::{Checker, Loader};
use crate::document::{Document, Editor, parse, without_mark};
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, quote};

/// A tier, a key, and what the text must set it to there.
type Difference = (Option<String>, String, SetTo);

/// A pipeline file into whose text changes are written.
pub struct Saver<'a> {
    document: Document,
    text: &'a str,
    loader: &'a dyn Loader,
    context: Context<'a>,
}

impl<'a> Saver<'a> {
    /// Reads a text. `file` is the name that messages show, and that files named in the text are relative to.
    ///
    /// # Errors
    /// The syntax errors of the text.
    pub fn new(file: &str, text: &'a str, registry: &'a Registry, loader: &'a dyn Loader) -> Result<Self, Diagnostics> {
        let document = parse(file, text)?;
        if document.problems.has_errors() {
            return Err(document.problems);
        }
        Ok(Self { document, text, loader, context: Context { registry, files: Files::new(loader) } })
    }

    /// The text with changes to the pipeline at a tier. Checked again at this tier, it has the new values.
    ///
    /// A value that the tier gives changes in the tier, and the other tiers keep theirs. Any other value changes for
    /// all tiers that give none of their own. A change to what the text states already changes nothing. If the tier is
    /// inherited, it is copied into the file with the change, because a tier replaces the inherited one of its name.
    ///
    /// # Errors
    /// Unknown names, values outside of their domain, a tier that is a file of its own, and all that makes the changed
    /// text wrong, at this tier or at another one that was right before. An error of a change itself points to the word
    /// `Pipeline`; one of the changed text points into that text.
    pub fn save(&self, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let state = self.context.state(&self.document, tier)?;
        let changes = resolve(&state, changes)?;
        let mut editor = self.editor();
        for change in &changes {
            state.write(&mut editor, tier, change);
        }
        self.verified(
            &state,
            editor,
            &ExpectedGraph { before: &self.document, tier, new_tier: None, changes: &changes },
        )
    }

    /// The text with a new tier, which is the pipeline at `tier` with changes. The rest stays.
    ///
    /// # Errors
    /// Those of [`Self::save`], and a name that a tier has.
    pub fn save_as_tier(&self, name: &str, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let state = self.context.state(&self.document, tier)?;
        if let Some((first, _)) = state.document.tiers.iter().find(|(known, _)| known.value == name) {
            let message = format!("the pipeline has a tier {} already", quote(name));
            let error = Diagnostic::error("doubled", message).also(&first.location, "this tier");
            return Err(alone(&state, error.help("choose another name")));
        }
        let changes = resolve(&state, changes)?;
        let mut editor = self.editor();
        editor.add_tier(name);
        if let Some(tier) = tier {
            state.copy_tier(&mut editor, tier, name);
        }
        for change in &changes {
            editor.add_to_tier(name, &state.key(change.subject), change.text.clone());
        }
        self.verified(
            &state,
            editor,
            &ExpectedGraph { before: &self.document, tier, new_tier: Some(name), changes: &changes },
        )
    }

    fn editor(&self) -> Editor<'a> {
        Editor::new(&self.document.file, without_mark(self.text))
    }

    /// The edited text, with overrides in the tiers that would differ from what they must state otherwise.
    fn verified(
        &self,
        state: &State<'_>,
        mut editor: Editor<'_>,
        expected: &ExpectedGraph<'_>,
    ) -> Result<String, Diagnostics> {
        if expected.changes.is_empty() && expected.new_tier.is_none() {
            return Ok(self.text.to_owned());
        }
        for (tier, key, must) in self.differences(&editor.text(), expected)? {
            if let Some(tier) = tier {
                state.write_to_tier(&mut editor, &tier, &key, must.text(&self.document.file));
            }
        }
        let text = editor.text();
        if let Some((_, key, _)) = self.differences(&text, expected)?.first() {
            return Err(alone(state, not_saved(key)));
        }
        self.check(&text, expected)?;
        let mark = &self.text[..self.text.len() - without_mark(self.text).len()];
        Ok(format!("{mark}{text}"))
    }

    /// At all tiers, where a text differs from what it must state.
    fn differences(&self, text: &str, expected: &ExpectedGraph<'_>) -> Result<Vec<Difference>, Diagnostics> {
        let saved = parse(&self.document.file, text)?;
        let mut all = Vec::new();
        for tier in self.context.state(&saved, None)?.tiers() {
            let found = expected.differences(&self.context, &saved, tier.as_deref())?;
            all.extend(found.into_iter().map(|(key, must)| (tier.clone(), key, must)));
        }
        Ok(all)
    }

    /// Checks that a text is right at all tiers at which it was right before. An error that the text had before at the
    /// tier that is saved is shown in that text.
    fn check(&self, text: &str, expected: &ExpectedGraph<'_>) -> Result<(), Diagnostics> {
        let saved = parse(&self.document.file, text)?;
        let checker = Checker::new(&saved, self.context.registry, self.loader);
        let before = Checker::new(&self.document, self.context.registry, self.loader);
        for tier in self.context.state(&saved, None)?.tiers() {
            let Err(errors) = checker.check(tier.as_deref(), &[]) else { continue };
            let is_new = tier.is_some() && tier.as_deref() == expected.new_tier;
            let tier = if is_new { expected.tier } else { tier.as_deref() };
            match (before.check(tier, &[]), tier) {
                (Err(errors), _) if tier == expected.tier => return Err(errors),
                (Ok(_), Some(other)) if tier != expected.tier => return Err(wrong_tier(&saved, other, errors)),
                (Ok(_), _) => return Err(errors),
                (Err(_), _) => {}
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
