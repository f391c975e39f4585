//! Save: the text is written with the changed values in it.

use std::path::Path;

use egui::{Context, Id, Key, Modal, RichText, TextEdit, Ui};

use super::Viewer;
use super::new_files::{NewFile, NewFiles, free_name};
use super::theme::{DIM, ERROR};
use crate::Problem;

impl Viewer {
    /// Writes the changes into the file, or into a new tier of it.
    pub(super) fn save(&mut self, ctx: &Context, new_tier: Option<&str>) {
        self.text.apply(&mut self.model);
        if !self.model.project().has_place() {
            return self.save_into_new_file(ctx, new_tier);
        }
        let saved = self.model.save(new_tier);
        self.tell_saved(ctx, saved);
    }

    /// Tells where the pipeline is saved, or why it is not.
    pub(super) fn tell_saved(&mut self, ctx: &Context, saved: Result<String, Problem>) {
        let waiting = self.model.changes().len();
        let told = match &saved {
            Ok(place) if waiting == 0 => format!("Saved: {place}"),
            Ok(place) => format!("Saved, with the errors of the text: {place}. {waiting} changed values wait."),
            Err(problem) => format!("Nothing is saved: {problem}"),
        };
        self.save_error = saved.is_err().then(|| told.clone());
        self.tell(ctx, told);
    }

    pub(super) fn save_button(&mut self, ui: &mut Ui) {
        if ui.add_enabled(self.is_unsaved(), egui::Button::new("Save")).on_hover_text(SAVE).clicked() {
            let ctx = ui.ctx().clone();
            self.save(&ctx, None);
        }
    }

    pub(super) fn save_as_tier_menu(&mut self, ui: &mut Ui) {
        ui.add_enabled_ui(self.is_unsaved(), |ui| {
            ui.menu_button("Save as tier", |ui| self.tier_name(ui));
        });
    }

    fn tier_name(&mut self, ui: &mut Ui) {
        ui.label(RichText::new("The changes become a tier of this name.").color(DIM));
        let response = ui.text_edit_singleline(&mut self.tier_name);
        let name = self.tier_name.trim().to_owned();
        let is_taken = self.model.tiers().contains(&name);
        if is_taken {
            ui.label(RichText::new("A tier has this name.").color(ERROR));
        }
        let can = !name.is_empty() && !is_taken;
        let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if ui.add_enabled(can, egui::Button::new("Save")).clicked() || entered && can {
            let ctx = ui.ctx().clone();
            self.save(&ctx, Some(&name));
            self.tier_name.clear();
            ui.close();
        }
    }
}

impl Viewer {
    /// Saves a pipeline that has no file.
    fn save_into_new_file(&mut self, ctx: &Context, new_tier: Option<&str>) {
        let name = self.model.project().name();
        match &self.new_files {
            NewFiles::Asked(_) if self.new_file.is_some() => {}
            NewFiles::Asked(_) => {
                let (path, new_tier) = (free_name(&name).display().to_string(), new_tier.map(str::to_owned));
                self.new_file = Some(NewFile { path, new_tier, error: None, was_focused: false });
            }
            NewFiles::Downloaded(_) => {
                let saved = self.write_new_file(&name, new_tier);
                self.tell_saved(ctx, saved);
            }
        }
    }

    fn write_new_file(&mut self, path: &str, new_tier: Option<&str>) -> Result<String, Problem> {
        let (NewFiles::Asked(make) | NewFiles::Downloaded(make)) = &self.new_files;
        let project = make(Path::new(path), self.model.files_in_memory())?;
        self.model.save_as(project, new_tier)
    }

    /// Asks for the path of a new file, while that question is open.
    pub(super) fn ask_for_new_file(&mut self, ctx: &Context) {
        let Some(mut asked) = self.new_file.take() else { return };
        let (mut saves, mut stays) = (false, false);
        let modal = Modal::new(Id::new("new file")).show(ctx, |ui| {
            ui.label(RichText::new(format!("{} is in no file yet. Save it as:", self.model.project().name())).strong());
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
            match self.write_new_file(asked.path.trim(), asked.new_tier.as_deref()) {
                Ok(place) => {
                    self.tell_saved(ctx, Ok(place));
                    self.go_on_if_saved();
                    return;
                }
                Err(problem) => (asked.error, asked.was_focused) = (Some(problem.to_string()), false),
            }
        }
        if !stays && (saves || !modal.should_close()) {
            self.new_file = Some(asked);
        }
    }
}

/// The place that a path means, for people.
fn absolute(path: &str) -> String {
    std::path::absolute(path.trim()).map_or(String::new(), |path| path.display().to_string())
}

const SAVE: &str = "Ctrl+S: writes the text, and the changed values into it; everything else stays as it is";
