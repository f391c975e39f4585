//! Saving, and the questions that it asks: unsaved changes, conflicts, the path of a new file, the name of a tier.

use std::path::Path;

use egui::{Button, Context, Id, Key, Modal, RichText, TextEdit};

use super::new_file::{NewFile, NewFiles, free_name};
use super::theme::{DIM, ERROR};
use crate::Problem;
use crate::model::{Conflict, Model, Project, Resolution, Target};

/// An action that would lose unsaved changes.
pub(super) enum Pending {
    Close,
    Open(Box<dyn Project>),
}

pub(super) struct SaveDialogs {
    new_files: NewFiles,
    /// The open question for the path of a new file.
    new_file: Option<NewFile>,
    /// The action that waits until the user has answered whether to save.
    pending: Option<Pending>,
    is_closing: bool,
    /// Error of the last attempt to save.
    error: Option<String>,
    /// The open question for the name of a new tier.
    new_tier: Option<NewTier>,
}

/// The question for the name of a tier, while it is open.
#[derive(Default)]
struct NewTier {
    name: String,
    /// The field has had the focus, which it gets once.
    was_focused: bool,
}

impl SaveDialogs {
    pub(super) fn new(new_files: NewFiles) -> Self {
        Self { new_files, new_file: None, pending: None, is_closing: false, error: None, new_tier: None }
    }

    /// True if the user types paths of files: in a browser there are none.
    pub(super) fn has_paths(&self) -> bool {
        matches!(self.new_files, NewFiles::Asked(_))
    }

    /// True while a question is open.
    pub(super) fn asks(&self) -> bool {
        self.new_file.is_some() || self.pending.is_some() || self.new_tier.is_some()
    }

    /// Asks for the name of a tier that the changes become.
    pub(super) fn ask_for_tier(&mut self) {
        self.new_tier = Some(NewTier::default());
    }

    /// True once the window is to be closed.
    pub(super) fn is_closing(&self) -> bool {
        self.is_closing
    }

    /// Error of the last attempt to save.
    pub(super) fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// Saves the model. Returns a message, unless the user is asked for a path.
    pub(super) fn save(&mut self, model: &mut Model, new_tier: Option<&str>) -> Option<String> {
        if model.editor().project().has_place() {
            let saved = model.save(new_tier);
            return Some(self.report(model, saved));
        }
        self.save_as(model, new_tier)
    }

    /// Saves the model as a new file, for whose path the user is asked.
    pub(super) fn save_as(&mut self, model: &mut Model, new_tier: Option<&str>) -> Option<String> {
        let name = model.editor().project().name();
        match &self.new_files {
            NewFiles::Asked(_) if self.new_file.is_some() => None,
            NewFiles::Asked(_) => {
                let (path, new_tier) = (free_name(&name).display().to_string(), new_tier.map(str::to_owned));
                self.new_file = Some(NewFile { path, new_tier, error: None, was_focused: false });
                None
            }
            NewFiles::Downloaded(_) => {
                let saved = self.write_new_file(model, &name, new_tier);
                Some(self.report(model, saved))
            }
        }
    }

    fn write_new_file(&self, model: &mut Model, path: &str, new_tier: Option<&str>) -> Result<String, Problem> {
        let (NewFiles::Asked(make) | NewFiles::Downloaded(make)) = &self.new_files;
        let project = make(Path::new(path), model.editor().files_in_memory())?;
        model.save_as(project, new_tier)
    }

    /// The message for a saved pipeline, or for an error.
    fn report(&mut self, model: &Model, saved: Result<String, Problem>) -> String {
        let waiting = model.editor().changes().len();
        let message = match &saved {
            Ok(place) if waiting == 0 => format!("Saved: {place}"),
            Ok(place) => format!("Saved, with the errors of the text: {place}. {waiting} changed values wait."),
            Err(problem) => format!("Nothing is saved: {problem}"),
        };
        self.error = saved.is_err().then(|| message.clone());
        message
    }

    /// Does what would lose unsaved changes, or asks first.
    pub(super) fn request(&mut self, model: &mut Model, pending: Pending) {
        // A hidden window draws no frames, and has not looked at the files.
        model.follow_files(None);
        if model.editor().is_saved() {
            self.finish(model, pending);
        } else {
            self.pending = Some(pending);
        }
    }

    fn finish(&mut self, model: &mut Model, pending: Pending) {
        match pending {
            Pending::Close => self.is_closing = true,
            Pending::Open(project) => model.open(project),
        }
    }

    /// Shows the question that is open. Returns a message.
    pub(super) fn show(&mut self, ctx: &Context, model: &mut Model) -> Option<String> {
        if let Some(conflict) = model.editor().conflict() {
            if let Some(resolution) = ask_about_conflict(ctx, model, conflict) {
                model.resolve(resolution);
                self.error = None;
            }
            return None;
        }
        if let Some(asked) = self.new_file.take() {
            return self.ask_for_new_file(ctx, model, asked);
        }
        match self.new_tier.take() {
            Some(asked) => self.ask_for_tier_name(ctx, model, asked),
            None => self.ask_to_save(ctx, model),
        }
    }

    fn ask_to_save(&mut self, ctx: &Context, model: &mut Model) -> Option<String> {
        let pending = self.pending.take()?;
        let then = match &pending {
            Pending::Close => "close".to_owned(),
            Pending::Open(project) => format!("open {}", project.name()),
        };
        let (mut saves, mut goes, mut stays) = (false, false, false);
        let modal = Modal::new(Id::new("unsaved changes")).show(ctx, |ui| {
            let text = format!("{} has changes that are not saved.", model.editor().project().name());
            ui.label(RichText::new(text).strong());
            ui.label(RichText::new("Without saving they are lost.").color(DIM));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                saves = ui.button(format!("Save and {then}")).clicked();
                goes = ui.button(format!("Without saving: {then}")).clicked();
                stays = ui.button("Stay").clicked();
            });
        });
        let message = if saves { self.save(model, None) } else { None };
        if self.new_file.is_some() {
            // The answer to that question goes on.
            self.pending = Some(pending);
        } else if goes || saves && model.editor().is_saved() {
            self.finish(model, pending);
        } else if !saves && !stays && !modal.should_close() {
            self.pending = Some(pending);
        }
        message
    }

    /// Asks for the path of a new file.
    fn ask_for_new_file(&mut self, ctx: &Context, model: &mut Model, mut asked: NewFile) -> Option<String> {
        let (mut saves, mut stays) = (false, false);
        let modal = Modal::new(Id::new("new file")).show(ctx, |ui| {
            let name = model.editor().project().name();
            ui.label(RichText::new(format!("{name} is in no file yet. Save it as:")).strong());
            let field = ui.add(TextEdit::singleline(&mut asked.path).desired_width(360.0));
            if !std::mem::replace(&mut asked.was_focused, true) {
                field.request_focus();
            }
            saves = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            ui.label(RichText::new(absolute(&asked.path)).color(DIM).small());
            if let Some(error) = &asked.error {
                ui.label(RichText::new(error).color(ERROR));
            }
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                saves |= ui.button("Save").clicked();
                stays = ui.button("Cancel").clicked();
            });
        });
        if saves {
            match self.write_new_file(model, asked.path.trim(), asked.new_tier.as_deref()) {
                Ok(place) => {
                    let message = self.report(model, Ok(place));
                    if let Some(pending) = self.pending.take_if(|_| model.editor().is_saved()) {
                        self.finish(model, pending);
                    }
                    return Some(message);
                }
                Err(problem) => (asked.error, asked.was_focused) = (Some(problem.to_string()), false),
            }
        }
        if !stays && (saves || !modal.should_close()) {
            self.new_file = Some(asked);
        }
        None
    }

    /// Asks for the name of a new tier.
    fn ask_for_tier_name(&mut self, ctx: &Context, model: &mut Model, mut asked: NewTier) -> Option<String> {
        let (mut saves, mut stays) = (false, false);
        let modal = Modal::new(Id::new("new tier")).show(ctx, |ui| {
            ui.label(RichText::new("The changes become a tier of this name:").strong());
            let field = ui.add(TextEdit::singleline(&mut asked.name).desired_width(240.0));
            if !std::mem::replace(&mut asked.was_focused, true) {
                field.request_focus();
            }
            let name = asked.name.trim();
            let is_taken = model.editor().tiers().iter().any(|tier| tier == name);
            if is_taken {
                ui.label(RichText::new("A tier has this name.").color(ERROR));
            }
            let can = !name.is_empty() && !is_taken;
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                saves = ui.add_enabled(can, Button::new("Save")).clicked() || entered && can;
                stays = ui.button("Cancel").clicked();
            });
            // Enter takes the keyboard from a field, and this name is not accepted.
            asked.was_focused &= !entered;
        });
        if saves {
            return self.save(model, Some(asked.name.trim()));
        }
        if !stays && !modal.should_close() {
            self.new_tier = Some(asked);
        }
        None
    }
}

/// Asks which changes to keep.
fn ask_about_conflict(ctx: &Context, model: &Model, conflict: &Conflict) -> Option<Resolution> {
    let name = model.editor().project().name();
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
    resolution
}

/// The absolute path, for people.
fn absolute(path: &str) -> String {
    std::path::absolute(path.trim()).map_or(String::new(), |path| path.display().to_string())
}
