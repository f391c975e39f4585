//! What is read from files: at the beginning, when they change, and after what is written to them.

use std::sync::Arc;

use afterimage_graph::check::{Change, Facts};

use super::{Model, Project};
use crate::Problem;

impl Model {
    /// Opens another pipeline; the images stay.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.project = project;
        (self.tier, self.tap, self.watched, self.beside, self.graph) = (None, None, None, None, None);
        self.changes.clear();
        self.facts = Facts::default();
        (self.shown, self.inspected, self.reference) = (None, None, None);
        self.clock.cut();
        self.reload();
    }

    /// Reads the pipeline again. If it is wrong, what was shown before is shown on.
    pub fn reload(&mut self) {
        match self.project.check(self.tier.as_deref()) {
            Ok(checked) => {
                (self.warnings, self.tiers, self.problem) = (checked.warnings, checked.tiers, None);
                self.graph = Some(Arc::new(checked.graph));
                self.apply_graph();
            }
            Err(errors) => self.problem = Some(Problem::Pipeline(errors)),
        }
    }

    /// Reads the pipeline and the images again if their files have changed. Returns whether those of the pipeline have.
    pub fn follow_files(&mut self) -> bool {
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
            self.reload();
        }
        has_changed
    }

    /// Replaces the text, without writing it.
    pub fn edit(&mut self, text: Option<String>) {
        self.project.edit(text);
        self.reload();
    }

    /// Writes all changes into the text of the pipeline, where everything else stays as it is, or into a new tier of
    /// it, which is shown from then on. They are no changes any more.
    ///
    /// # Errors
    /// Why they cannot be written; nothing is written then.
    pub fn save(&mut self, new_tier: Option<&str>) -> Result<(), Problem> {
        let changes: Vec<Change> = self.changes.iter().map(|(target, value)| target.change(value)).collect();
        let text = self.project.saved(self.tier.as_deref(), new_tier, &changes).map_err(Problem::Pipeline)?;
        self.project.write(&text).map_err(Problem::said)?;
        self.changes.clear();
        self.tier = new_tier.map(str::to_owned).or(self.tier.take());
        self.reload();
        self.each_chain(|chain| chain.forget_values());
        Ok(())
    }
}
