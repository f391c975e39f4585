//! A message that is shown for a few seconds.

use egui::{Context, Ui};

const SECONDS: f64 = 6.0;

/// The text, and the time at which it was set.
#[derive(Default)]
pub(super) struct Message(Option<(String, f64)>);

impl Message {
    pub(super) fn set(&mut self, ctx: &Context, text: String) {
        self.0 = Some((text, ctx.input(|input| input.time)));
    }

    pub(super) fn show(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        self.0.take_if(|(_, since)| now - *since > SECONDS);
        let Some((text, _)) = &self.0 else { return };
        let anchor = egui::Align2::CENTER_BOTTOM;
        egui::Area::new("message".into()).anchor(anchor, [0.0, -280.0]).show(ui.ctx(), |ui| {
            ui.set_max_width((ui.ctx().content_rect().width() - 48.0).max(120.0));
            egui::Frame::popup(ui.style()).show(ui, |ui| match text.contains('\n') {
                // Excerpts of a text are aligned by their letters.
                true => ui.monospace(text),
                false => ui.label(text),
            });
        });
    }
}
