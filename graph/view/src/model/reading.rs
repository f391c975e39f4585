//! Reads files, follows their changes, and saves.

use std::sync::Arc;

use afterimage_graph::check::{Change, Facts};
use afterimage_graph::value::Value;

use super::chains::Chains;
use super::conflict::{Conflict, Resolution};
use super::{Changes, Model, Project, Target};
use crate::Problem;

impl Model {
    /// Opens another pipeline; the images stay. Unsaved changes are lost.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.project = project;
        (self.tap, self.watched, self.graph, self.conflict) = (None, None, None, None);
        self.facts = Facts::default();
        self.chains = Chains::default();
        self.clock.cut();
        self.load();
    }

    /// Reads the text for the first time, and checks it.
    pub(super) fn load(&mut self) {
        match self.project.read() {
            Ok(text) => {
                self.changes = Changes::new(&text);
                self.reload();
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
                (self.is_stale, self.savings) = (true, None);
            }
            Ok(false) => {}
            Err(problem) => self.problem = Some(problem),
        }
        let has_changed = self.project.has_changed();
        if has_changed {
            if let Some(typed) = typed {
                self.edit(typed);
            }
            match self.project.read() {
                Ok(text) if text == self.changes.written() => self.reload(),
                Ok(text) => self.follow_text(text),
                Err(errors) => self.problem = Some(Problem::Pipeline(errors)),
            }
        }
        has_changed
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
    /// which is shown from then on. A text with errors is written as it is, and the values stay changes.
    ///
    /// # Errors
    /// The file was changed, too, and the user has to choose; or the values or the file cannot be written. Nothing is
    /// written then.
    pub fn save(&mut self, new_tier: Option<&str>) -> Result<(), Problem> {
        // The file may have changed since it was looked at last. One that is gone is written again.
        if let Ok(text) = self.project.read()
            && text != self.changes.written()
        {
            self.follow_text(text);
        }
        if self.conflict.is_some() {
            return Err(Problem::message("the file was changed by another program, too")
                .hint("choose whether yours or the file's is kept, and save again"));
        }
        if self.has_errors && new_tier.is_none() {
            self.project.write(self.changes.text()).map_err(Problem::message)?;
            self.changes.save_text();
            return Ok(());
        }
        let values: Vec<Change> = self.changes.iter().map(|(target, value)| target.change(value)).collect();
        let tier = self.changes.tier().map(str::to_owned);
        let saved = self.project.saved(self.changes.text(), tier.as_deref(), new_tier, &values);
        let text = saved.map_err(Problem::Pipeline)?;
        self.project.write(&text).map_err(Problem::message)?;
        self.changes.save(&text, new_tier.map(str::to_owned).or(tier));
        self.reload();
        self.chains.reset_values(&self.changes);
        Ok(())
    }
}
