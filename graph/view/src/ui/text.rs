//! The text of the pipeline, and its errors and warnings.

use std::ops::RangeInclusive;

use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Severity, shown};
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditOutput;
use egui::{Color32, Context, Id, RichText, ScrollArea, Ui};

use super::completion::Completion;
use super::text_colors::Colors;
use super::text_find::Find;
use super::text_place::TextPlace;
use super::theme::{ACCENT, DIM, ERROR};
use crate::Problem;
use crate::model::Model;

/// Seconds without a key after which a text is checked.
const PAUSE: f64 = 0.25;
/// The width of the numbers of lines, in points.
const GUTTER: i8 = 38;

#[derive(Default)]
pub(super) struct TextPanel {
    text: String,
    /// The text that the model has.
    known: String,
    /// The time of the last change.
    typed: Option<f64>,
    /// The line to which the panel goes.
    goal: Option<usize>,
    /// The selected node, and its lines in the text.
    marked: Option<(String, Option<RangeInclusive<usize>>)>,
    /// The panel scrolls to the marked lines.
    reveals: bool,
    find: Find,
    colors: Colors,
    completion: Completion,
}

impl TextPanel {
    /// Goes to a line, counted from 1.
    pub(super) fn go_to(&mut self, line: usize) {
        self.goal = Some(line);
    }

    /// Scrolls to the lines of the selected node, without taking the keyboard.
    pub(super) fn reveal(&mut self) {
        self.reveals = true;
    }

    /// Opens the field that finds words in the text.
    pub(super) fn open_find(&mut self) {
        self.find.open();
    }

    /// The text that is being typed, if the model has not got it yet.
    pub(super) fn typed(&self) -> Option<&str> {
        self.typed.is_some().then_some(&*self.text)
    }

    /// Applies the typed text to the model without waiting for a pause.
    pub(super) fn apply(&mut self, model: &mut Model) {
        if self.typed.take().is_some() {
            self.known.clone_from(&self.text);
            model.edit(&self.text);
        }
    }

    /// True if keys are typed into the text.
    pub(super) fn has_focus(ctx: &Context) -> bool {
        ctx.memory(|memory| memory.has_focus(field()))
    }

    /// Shows the text; what is typed is checked after a pause. The lines of the selected node are marked.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, selected: Option<&str>) {
        if *model.editor().text() != self.known {
            (self.text, self.known, self.typed) =
                (model.editor().text().to_owned(), model.editor().text().to_owned(), None);
            self.marked = None;
        }
        if self.marked.as_ref().map(|(node, _)| &**node) != selected {
            self.marked = selected.map(|node| (node.to_owned(), model.editor().lines_of(node)));
        }
        let is_list_closed = self.completion.keys(ui, model, Self::has_focus(ui.ctx()));
        let is_closed = self.find.show(ui, &self.text) || is_list_closed;
        let now = ui.input(|input| input.time);
        ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            let colors = &mut self.colors;
            let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, width: f32| {
                let mut job = colors.job(ui, text.as_str()).clone();
                job.wrap.max_width = width;
                ui.fonts_mut(|fonts| fonts.layout_job(job))
            };
            let edit = egui::TextEdit::multiline(&mut self.text).id(field()).code_editor().desired_width(f32::INFINITY);
            let margin = egui::Margin { left: GUTTER, right: 4, top: 2, bottom: 2 };
            let output = edit.margin(margin).layouter(&mut layout).show(ui);
            number_lines(ui, &output);
            if output.response.changed() {
                self.typed = Some(now);
            }
            if let Some(line) = self.goal.take() {
                self.put_cursor(ui, &output, line);
            }
            wrong_lines(model).into_iter().for_each(|line| mark(ui, &output, line, ERROR));
            self.mark_selected(ui, &output);
            self.find.mark(ui, &output, &self.text);
            if is_closed {
                output.response.request_focus();
            }
            self.complete(ui, model, &output);
        });
        match self.typed {
            Some(typed) if now - typed >= PAUSE => self.apply(model),
            Some(_) => ui.ctx().request_repaint_after(std::time::Duration::from_millis(50)),
            None => {}
        }
    }

    /// Writes what is taken from the list at the cursor.
    fn complete(&mut self, ui: &Ui, model: &Model, output: &TextEditOutput) {
        let Some(cursor) = output.cursor_range.map(|range| range.primary.index.0) else { return };
        let byte_of = |text: &str, at: usize| text.char_indices().nth(at).map_or(text.len(), |(byte, _)| byte);
        let at = byte_of(&self.text, cursor);
        self.completion.follow(model, TextPlace::of(&self.text, &self.colors.tokens, at));
        let Some((taken, replaced)) = self.completion.show(ui, model, output) else { return };
        let end = replaced.start + taken.text.len() - taken.back;
        self.text.replace_range(replaced, &taken.text);
        self.typed = Some(ui.input(|input| input.time));
        let mut state = output.state.clone();
        let cursor = CCursor::new(self.text[..end].chars().count());
        state.cursor.set_char_range(Some(CCursorRange::one(cursor)));
        state.store(ui.ctx(), output.response.id);
        output.response.request_focus();
    }

    /// Shows the manual of the kind that the cursor is in.
    pub(super) fn docs(&self, ui: &mut Ui) {
        self.completion.docs(ui);
    }

    /// Marks the lines of the selected node.
    fn mark_selected(&mut self, ui: &Ui, output: &TextEditOutput) {
        let Some((_, Some(lines))) = &self.marked else { return };
        lines.clone().for_each(|line| mark(ui, output, line, ACCENT));
        if std::mem::take(&mut self.reveals)
            && let Some(rect) = line_rect(output, *lines.start())
        {
            ui.scroll_to_rect(rect.with_max_x(rect.min.x), Some(egui::Align::Center));
        }
    }

    /// Puts the cursor at the beginning of a line and the line into the middle, so that keys, Ctrl+Z among them, belong
    /// to the text.
    fn put_cursor(&self, ui: &mut Ui, output: &TextEditOutput, line: usize) {
        let before: usize = self.text.split_inclusive('\n').take(line - 1).map(|line| line.chars().count()).sum();
        let mut state = output.state.clone();
        state.cursor.set_char_range(Some(CCursorRange::one(CCursor::new(before))));
        state.store(ui.ctx(), output.response.id);
        output.response.request_focus();
        if let Some(rect) = line_rect(output, line) {
            ui.scroll_to_rect(rect.with_max_x(rect.min.x), Some(egui::Align::Center));
        }
    }
}

/// The field of the text. An identity that egui counts changes with what is shown before the field, such as errors, and
/// the field would lose the keyboard.
fn field() -> Id {
    Id::new("text of the pipeline")
}

/// The area of the first row of a line; a long one may have several.
fn line_rect(output: &TextEditOutput, line: usize) -> Option<egui::Rect> {
    let rows = &output.galley.rows;
    let ends = rows.iter().enumerate().filter(|(_, row)| row.ends_with_newline).map(|(index, _)| index + 1);
    let first = std::iter::once(0).chain(ends).nth(line - 1)?;
    Some(rows.get(first)?.rect().translate(output.galley_pos.to_vec2()))
}

fn mark(ui: &Ui, output: &TextEditOutput, line: usize, color: Color32) {
    if let Some(rect) = line_rect(output, line) {
        let rect = rect.expand2(egui::vec2(3.0, 0.0));
        ui.painter().rect_filled(rect, 2.0, color.gamma_multiply_u8(0x30));
    }
}

/// Writes the numbers of the lines beside them.
fn number_lines(ui: &Ui, output: &TextEditOutput) {
    let (mut line, mut is_first) = (1, true);
    for row in &output.galley.rows {
        let rect = row.rect().translate(output.galley_pos.to_vec2());
        if is_first && ui.clip_rect().y_range().intersects(rect.y_range()) {
            let at = egui::pos2(rect.min.x - 10.0, rect.center().y);
            let font = egui::FontId::monospace(10.0);
            ui.painter().text(at, egui::Align2::RIGHT_CENTER, line.to_string(), font, Color32::from_gray(0x60));
        }
        is_first = row.ends_with_newline;
        line += usize::from(is_first);
    }
}

/// The lines of the text at which errors are.
fn wrong_lines(model: &Model) -> Vec<usize> {
    let Some(Problem::Pipeline(errors)) = model.problem() else { return Vec::new() };
    errors.into_iter().filter_map(|error| own_line(model, errors, error)).collect()
}

/// The line of the shown text that a message is about; `None` if it is about another file.
fn own_line(model: &Model, found: &Diagnostics, diagnostic: &Diagnostic) -> Option<usize> {
    let location = &diagnostic.labels.first()?.location;
    let name = model.editor().project().name();
    let file = shown(&location.file);
    let is_own = file == *name || file.ends_with(&name);
    Some(found.sources.position(&location.file, location.start).filter(|_| is_own)?.line)
}

/// Shows errors and warnings; a click on a location returns its line. `others` are those that the model does not know,
/// and `nothing` is the text without any.
pub(super) fn messages(ui: &mut Ui, model: &Model, others: &[String], nothing: &str) -> Option<usize> {
    let mut line = None;
    ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
        for text in others {
            ui.label(RichText::new(text).monospace().color(ERROR));
        }
        match model.problem() {
            Some(Problem::Pipeline(errors)) => line = list(ui, model, errors),
            Some(other) => drop(ui.label(RichText::new(other.to_string()).monospace().color(ERROR))),
            None if !has_messages(model) && others.is_empty() => {
                ui.label(RichText::new(nothing).color(DIM));
            }
            None => {}
        }
        if let Some(checked) = model.editor().checked() {
            line = list(ui, model, &checked.warnings).or(line);
        }
        for (input, repairs) in model.images().repairs() {
            let text = format!("the image of input `{input}` has pixels that are repaired: {repairs}");
            ui.label(RichText::new(text).monospace().color(ACCENT));
        }
        for faults in model.kernel_faults() {
            ui.label(RichText::new(faults.to_string()).monospace().color(ACCENT));
        }
    });
    line
}

/// States that a panel shows an earlier text, while the present one has errors.
pub(super) fn note_errors(ui: &mut Ui, model: &Model) {
    if model.editor().has_errors() {
        let text = "The text has errors: this is the last one without.";
        ui.add(egui::Label::new(RichText::new(text).color(ERROR).small()).truncate());
    }
}

/// True if there are errors, warnings, faults of kinds in folders, or pixels that no image can show.
pub(super) fn has_messages(model: &Model) -> bool {
    let has_warnings = model.editor().checked().is_some_and(|checked| !checked.warnings.is_empty());
    let has_faults = !model.kernel_faults().is_empty() || !model.images().repairs().is_empty();
    model.problem().is_some() || has_warnings || has_faults
}

fn list(ui: &mut Ui, model: &Model, found: &Diagnostics) -> Option<usize> {
    let mut chosen = None;
    for diagnostic in found {
        let color = if diagnostic.severity == Severity::Error { ERROR } else { ACCENT };
        ui.horizontal(|ui| {
            if let Some(label) = diagnostic.labels.first() {
                let place = found.sources.position(&label.location.file, label.location.start);
                if let Some(place) = place {
                    let file = shown(&label.location.file);
                    let link = ui.link(RichText::new(format!("{file}:{}:{}", place.line, place.column)).monospace());
                    if link.clicked() {
                        chosen = own_line(model, found, diagnostic).or(chosen);
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
