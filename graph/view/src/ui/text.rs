//! The text of the pipeline, and what is wrong with it.

use afterimage_graph::diagnostic::Severity;
use egui::{Color32, RichText, ScrollArea, Ui};

use super::theme::{ACCENT, DIM, ERROR};
use crate::Problem;
use crate::model::Model;

/// Seconds without a key after which a text is tried.
const PAUSE: f64 = 0.25;

/// What the panel remembers.
#[derive(Default)]
pub(super) struct TextPanel {
    text: String,
    /// The text that the model has.
    known: String,
    /// When the text was changed last.
    typed: Option<f64>,
    /// The line to which the panel scrolls.
    goal: Option<usize>,
}

impl TextPanel {
    /// Goes to a line, counted from 1.
    pub(super) fn go_to(&mut self, line: usize) {
        self.goal = Some(line);
    }

    /// Shows the text; what is typed is tried after a pause.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model) {
        let present = model.project().text();
        if present != self.known {
            (self.text, self.known, self.typed) = (present.clone(), present, None);
        }
        let now = ui.input(|input| input.time);
        ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            let edit = egui::TextEdit::multiline(&mut self.text).code_editor().desired_width(f32::INFINITY);
            let output = edit.show(ui);
            if output.response.changed() {
                self.typed = Some(now);
            }
            if let Some(line) = self.goal.take() {
                self.scroll_to(ui, &output, line);
            }
        });
        match self.typed {
            Some(typed) if now - typed >= PAUSE => {
                (self.typed, self.known) = (None, self.text.clone());
                model.edit(Some(self.text.clone()));
            }
            Some(_) => ui.ctx().request_repaint_after(std::time::Duration::from_millis(50)),
            None => {}
        }
    }

    fn scroll_to(&self, ui: &mut Ui, output: &egui::text_edit::TextEditOutput, line: usize) {
        let row = output.galley.rows.get(line.saturating_sub(1));
        if let Some(row) = row {
            let rect = row.rect().translate(output.galley_pos.to_vec2());
            ui.scroll_to_rect(rect, Some(egui::Align::Center));
            ui.painter().rect_filled(rect.expand(2.0), 2.0, Color32::from_rgba_unmultiplied(0xf0, 0x6a, 0x5c, 60));
        }
    }
}

/// Shows what is wrong; a click on a location gives its line.
pub(super) fn messages(ui: &mut Ui, model: &Model) -> Option<usize> {
    let mut line = None;
    ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
        match model.problem() {
            Some(Problem::Pipeline(errors)) => line = list(ui, model, errors),
            Some(other) => drop(ui.label(RichText::new(other.to_string()).monospace().color(ERROR))),
            None if model.warnings().is_empty() => {
                ui.label(RichText::new("Nothing is wrong.").color(DIM));
            }
            None => {}
        }
        line = list(ui, model, model.warnings()).or(line);
    });
    line
}

fn list(ui: &mut Ui, model: &Model, found: &afterimage_graph::diagnostic::Diagnostics) -> Option<usize> {
    let mut chosen = None;
    for diagnostic in found {
        let color = if diagnostic.severity == Severity::Error { ERROR } else { ACCENT };
        ui.horizontal(|ui| {
            if let Some(label) = diagnostic.labels.first() {
                let place = found.sources.position(&label.location.file, label.location.start);
                if let Some(place) = place {
                    let is_own = *label.location.file == *model.project().name()
                        || label.location.file.ends_with(&model.project().name());
                    let link = ui.link(
                        RichText::new(format!("{}:{}:{}", label.location.file, place.line, place.column)).monospace(),
                    );
                    if link.clicked() && is_own {
                        chosen = Some(place.line);
                    }
                }
            }
            ui.label(RichText::new(&diagnostic.message).color(color));
        });
        if let Some(help) = &diagnostic.help {
            ui.label(RichText::new(format!("    {help}")).color(DIM));
        }
    }
    if !found.is_empty() {
        ui.add_space(6.0);
        ui.label(RichText::new(found.to_string()).monospace().color(Color32::from_gray(0xb8)));
    }
    chosen
}
