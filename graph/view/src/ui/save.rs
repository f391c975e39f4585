//! Save: the text is written with the changed values in it.

use egui::{Context, RichText, Ui};

use super::Viewer;
use super::theme::{DIM, ERROR};

impl Viewer {
    /// Writes the changes into the file, or into a new tier of it.
    pub(super) fn save(&mut self, ctx: &Context, new_tier: Option<&str>) {
        self.text.apply(&mut self.model);
        let saved = self.model.save(new_tier);
        self.save_error = saved.err().map(|problem| format!("Nothing is saved: {problem}"));
        let name = self.model.project().name();
        let waiting = self.model.changes().len();
        let done = if waiting == 0 {
            format!("{name} is saved.")
        } else {
            format!("The text of {name} is saved with its errors. {waiting} changed values wait until it has none.")
        };
        self.tell(ctx, self.save_error.clone().unwrap_or(done));
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
        let entered = response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if ui.add_enabled(can, egui::Button::new("Save")).clicked() || entered && can {
            let ctx = ui.ctx().clone();
            self.save(&ctx, Some(&name));
            self.tier_name.clear();
            ui.close();
        }
    }
}

const SAVE: &str = "Ctrl+S: writes the text, and the changed values into it; everything else stays as it is";
