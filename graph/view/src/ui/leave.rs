//! Leaving the window with changes that are not saved.

use egui::{Context, Id, Modal, RichText};

use super::Viewer;
use super::leaving::QuitPrompt;
use super::theme::DIM;

impl Viewer {
    /// Closes the window, or asks first if changes would be lost.
    pub fn leave(&mut self) {
        self.leaving = if self.model.changes().is_empty() { QuitPrompt::Leaves } else { QuitPrompt::Asks };
    }

    /// Whether the window is to be closed now.
    pub fn is_leaving(&self) -> bool {
        self.leaving == QuitPrompt::Leaves
    }

    /// The question, while it is open.
    pub(super) fn ask_before_leaving(&mut self, ctx: &Context) {
        if self.leaving != QuitPrompt::Asks {
            return;
        }
        let modal = Modal::new(Id::new("leaving")).show(ctx, |ui| {
            let text = format!("{} has changes that are not saved.", self.model.project().name());
            ui.label(RichText::new(text).strong());
            ui.label(RichText::new("Without saving they are lost.").color(DIM));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Save and close").clicked() {
                    self.save(ctx, None);
                    self.leaving = if self.unsaved.is_none() { QuitPrompt::Leaves } else { QuitPrompt::Stays };
                }
                if ui.button("Close without saving").clicked() {
                    self.leaving = QuitPrompt::Leaves;
                }
                if ui.button("Stay").clicked() {
                    self.leaving = QuitPrompt::Stays;
                }
            });
        });
        if modal.should_close() && self.leaving == QuitPrompt::Asks {
            self.leaving = QuitPrompt::Stays;
        }
    }
}
