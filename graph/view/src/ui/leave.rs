//! What would lose unsaved changes asks first; and what to do when the file was changed, too.

use egui::{Context, Id, Modal, RichText};

use super::Viewer;
use super::pending::Pending;
use super::theme::DIM;
use crate::model::{Conflict, Project, Resolution, Target};

impl Viewer {
    /// Closes the window, or asks first if changes would be lost.
    pub fn leave(&mut self) {
        self.request(Pending::Close);
    }

    /// Opens another pipeline, or asks first if changes would be lost.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.request(Pending::Open(project));
    }

    /// Whether the window is to be closed now.
    pub fn is_leaving(&self) -> bool {
        self.is_leaving
    }

    /// Whether the text or a value differs from the file.
    pub fn is_unsaved(&self) -> bool {
        !self.model.is_saved() || self.text.typed().is_some_and(|typed| typed != self.model.text())
    }

    fn request(&mut self, pending: Pending) {
        self.text.apply(&mut self.model);
        // A hidden window draws no frames, and has not looked at the files.
        self.model.follow_files(None);
        if self.is_unsaved() {
            self.pending = Some(pending);
        } else {
            self.finish(pending);
        }
    }

    /// Does what waits for the answer whether to save, once everything is saved.
    pub(super) fn go_on_if_saved(&mut self) {
        if let Some(pending) = self.pending.take_if(|_| self.model.is_saved()) {
            self.finish(pending);
        }
    }

    fn finish(&mut self, pending: Pending) {
        match pending {
            Pending::Close => self.is_leaving = true,
            Pending::Open(project) => self.model.open(project),
        }
    }

    /// The question whether to save, while it is open.
    pub(super) fn ask_to_save(&mut self, ctx: &Context) {
        let Some(pending) = self.pending.take() else { return };
        let then = match &pending {
            Pending::Close => "close".to_owned(),
            Pending::Open(project) => format!("open {}", project.name()),
        };
        let (mut saves, mut goes, mut stays) = (false, false, false);
        let modal = Modal::new(Id::new("leaving")).show(ctx, |ui| {
            let text = format!("{} has changes that are not saved.", self.model.project().name());
            ui.label(RichText::new(text).strong());
            ui.label(RichText::new("Without saving they are lost.").color(DIM));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                saves = ui.button(format!("Save and {then}")).clicked();
                goes = ui.button(format!("Without saving: {then}")).clicked();
                stays = ui.button("Stay").clicked();
            });
        });
        if saves {
            self.save(ctx, None);
            if self.new_file.is_some() {
                // The answer to that question goes on.
                self.pending = Some(pending);
                return;
            }
            stays = self.is_unsaved();
        }
        if goes || saves && !stays {
            self.finish(pending);
        } else if !stays && !modal.should_close() {
            self.pending = Some(pending);
        }
    }

    /// The question which changes to keep, while there is a conflict.
    pub(super) fn ask_about_conflict(&mut self, ctx: &Context) {
        let Some(conflict) = self.model.conflict() else { return };
        let name = self.model.project().name();
        let what = match conflict {
            Conflict::Text(_) => format!("The text of {name} was changed here and by another program."),
            Conflict::Values(targets) => {
                let names: Vec<&str> = targets.iter().map(Target::name).collect();
                format!("Changed here and by another program in {name}: {}.", names.join(", "))
            }
        };
        let mut resolution = None;
        Modal::new(Id::new("conflict")).show(ctx, |ui| {
            ui.label(RichText::new(what).strong());
            ui.label(RichText::new("Undo goes back from the file's version to yours.").color(DIM));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Keep mine").clicked() {
                    resolution = Some(Resolution::KeepMine);
                }
                if ui.button("Take the file's").clicked() {
                    resolution = Some(Resolution::TakeFile);
                }
            });
        });
        if let Some(resolution) = resolution {
            self.model.resolve(resolution);
            self.save_error = None;
        }
    }
}
