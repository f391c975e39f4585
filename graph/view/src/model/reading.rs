//! Reads files, follows their changes, and saves.

use std::sync::Arc;

use afterimage_graph::check::{Change, Facts};
use afterimage_graph::value::Value;

use super::chains::Chains;
use super::conflict::{Conflict, Resolution};
use super::{Changes, Model, NamedFile, Project, Target};
use crate::Problem;

impl Model {
    /// Opens another pipeline; the images stay. Unsaved changes are lost.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.project = project;
        (self.tap, self.watched, self.graph, self.conflict) = (None, None, None, None);
        self.is_gone = false;
        self.facts = Facts::default();
        self.chains = Chains::default();
        self.clock.cut();
        self.load();
    }

    /// Reads the text for the first time, and checks it.
    pub(super) fn load(&mut self) {
        match self.project.read() {
            Ok(Some(text)) => {
                self.changes = Changes::new(&text);
                self.reload();
            }
            Ok(None) => {
                self.changes = Changes::default();
                self.problem = Some(Problem::message(format!("there is no file `{}`", self.project.name())));
            }
            Err(errors) => {
                self.changes = Changes::default();
                self.problem = Some(Problem::Pipeline(errors));
            }
        }
    }

    /// Checks the text again. If it has errors, the last good pipeline continues to render.
    pub fn reload(&mut self) {
        let checked = self.project.check(self.changes.text(), self.changes.tier());
        self.has_errors = checked.is_err();
        match checked {
            Ok(checked) => {
                (self.warnings, self.tiers, self.problem) = (checked.warnings, checked.tiers, None);
                (self.claims, self.fact_meanings) = (checked.claims, checked.facts);
                self.graph = Some(Arc::new(checked.graph));
                self.apply_graph();
            }
            Err(errors) => self.problem = Some(Problem::Pipeline(errors)),
        }
    }

    /// Reads the pipeline and the images again if their files have changed. Returns whether those of the pipeline have.
    /// `typed` is a text that the user is typing and that [`edit`](Self::edit) has not got yet: it counts as changed.
    pub fn follow_files(&mut self, typed: Option<&str>) -> bool {
        match self.images.follow() {
            Ok(true) => {
                self.forget_problem();
                self.is_stale = true;
            }
            Ok(false) => {}
            Err(problem) => self.problem = Some(problem),
        }
        let has_changed = self.project.has_changed();
        if has_changed {
            if let Some(typed) = typed {
                self.edit(typed);
            }
            let read = self.project.read();
            self.is_gone = matches!(read, Ok(None));
            match read {
                Ok(Some(text)) if text == self.changes.written() => self.reload(),
                Ok(Some(text)) => self.follow_text(text),
                Ok(None) => {
                    let gone = Problem::message(format!("the file `{}` is gone", self.project.name()));
                    self.problem = Some(gone.hint("a save writes it again"));
                }
                Err(errors) => self.problem = Some(Problem::Pipeline(errors)),
            }
        }
        has_changed
    }

    /// Whether the text and all values are in the file.
    pub fn is_saved(&self) -> bool {
        self.changes.is_empty() && !self.is_gone
    }

    /// The file has another text than before.
    fn follow_text(&mut self, text: String) {
        if self.changes.is_text_changed() && text != self.changes.text() {
            self.conflict = Some(Conflict::Text(text));
        } else {
            self.take_text(&text);
        }
    }

    /// Shows the text of the file. Values that were changed in it and by the user are a conflict.
    fn take_text(&mut self, text: &str) {
        let before = self.graph.clone();
        self.changes.set_written(text);
        self.reload();
        let (Some(before), Some(now)) = (before, self.graph.clone()) else { return };
        let mut conflicting = Vec::new();
        let values: Vec<(Target, Value)> =
            self.changes.iter().map(|(target, value)| (target.clone(), value.clone())).collect();
        for (target, value) in values {
            let written = target.written(&now);
            if written.as_ref() == Some(&value) {
                self.changes.forget(&target);
            } else if written != target.written(&before) {
                conflicting.push(target);
            }
        }
        self.conflict = (!conflicting.is_empty()).then_some(Conflict::Values(conflicting));
    }

    /// The conflict that the user has to resolve before anything can be saved.
    pub fn conflict(&self) -> Option<&Conflict> {
        self.conflict.as_ref()
    }

    /// Resolves the conflict, if there is one.
    pub fn resolve(&mut self, resolution: Resolution) {
        match (self.conflict.take(), resolution) {
            (Some(Conflict::Text(text)), Resolution::KeepMine) => self.changes.set_written(&text),
            (Some(Conflict::Text(text)), Resolution::TakeFile) => {
                self.changes.edit(&text);
                self.take_text(&text);
            }
            (Some(Conflict::Values(targets)), Resolution::TakeFile) => {
                self.changes.revert(&targets);
                self.apply_graph();
                self.chains.reset_values(&self.changes);
            }
            (Some(Conflict::Values(_)), Resolution::KeepMine) | (None, _) => {}
        }
    }

    /// Replaces the text, without writing it.
    pub fn edit(&mut self, text: &str) {
        self.changes.edit(text);
        self.reload();
    }

    /// The text with all changed values in it, as [`save`](Self::save) would write it. While the text has errors, it is
    /// the text alone.
    pub fn text_with_changes(&self) -> String {
        let values: Vec<Change> = self.changes.iter().map(|(target, value)| target.change(value)).collect();
        let saved = self.project.saved(self.changes.text(), self.changes.tier(), None, &values);
        saved.unwrap_or_else(|_| self.changes.text().to_owned())
    }

    /// Writes the text with all changed values in it, where everything else stays as it is, or into a new tier of it,
    /// which is shown from then on. A text with errors is written as it is, and the values stay changes. Returns where
    /// the text is now, for people.
    ///
    /// # Errors
    /// The file was changed, too, and the user has to choose; it cannot be read, and is not replaced; the values cannot
    /// be written; or the project has no place. Nothing is written then.
    pub fn save(&mut self, new_tier: Option<&str>) -> Result<String, Problem> {
        // The file may have changed since it was looked at last. One that is gone is written again.
        if let Some(text) = self.project.read().map_err(Problem::Pipeline)?
            && text != self.changes.written()
        {
            self.follow_text(text);
        }
        if self.conflict.is_some() {
            return Err(Problem::message("the file was changed by another program, too")
                .hint("choose whether yours or the file's is kept, and save again"));
        }
        let text = self.text_to_save(new_tier)?;
        let place = self.project.write(&text).map_err(Problem::message)?;
        self.note_saved(&text, new_tier);
        Ok(place)
    }

    /// The same into another place, where the pipeline is from then on; the history stays.
    ///
    /// # Errors
    /// The values or the text cannot be written. The pipeline stays where it was then.
    pub fn save_as(&mut self, mut project: Box<dyn Project>, new_tier: Option<&str>) -> Result<String, Problem> {
        let text = self.text_to_save(new_tier)?;
        let place = project.write(&text).map_err(Problem::message)?;
        (self.project, self.conflict) = (project, None);
        self.note_saved(&text, new_tier);
        Ok(place)
    }

    /// The files that the pipeline names and that are in memory alone.
    pub fn files_in_memory(&self) -> Vec<NamedFile> {
        self.project.files_in_memory(self.changes.text())
    }

    /// The text that a save writes.
    fn text_to_save(&self, new_tier: Option<&str>) -> Result<String, Problem> {
        if self.has_errors && new_tier.is_none() {
            return Ok(self.changes.text().to_owned());
        }
        let values: Vec<Change> = self.changes.iter().map(|(target, value)| target.change(value)).collect();
        let saved = self.project.saved(self.changes.text(), self.changes.tier(), new_tier, &values);
        saved.map_err(Problem::Pipeline)
    }

    /// Notes that this text, which [`text_to_save`](Self::text_to_save) has made, is written.
    fn note_saved(&mut self, text: &str, new_tier: Option<&str>) {
        self.is_gone = false;
        if self.has_errors && new_tier.is_none() {
            self.changes.save_text();
            return self.reload();
        }
        let tier = new_tier.or(self.changes.tier()).map(str::to_owned);
        self.changes.save(text, tier);
        self.reload();
        self.chains.reset_values(&self.changes);
    }
}
