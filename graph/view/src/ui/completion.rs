//! Completion of the text at the cursor, and the manual of the kind that the cursor is in.

use afterimage_graph::node::NodeKind;
use egui::text_edit::TextEditOutput;
use egui::{Area, Button, Color32, Frame, Id, Key, Modifiers, Order, Pos2, RichText, ScrollArea, Ui};

use super::entry::entry;
use super::proposals::{Known, Proposal, short_type};
use super::text_place::TextPlace;
use super::theme::{ACCENT, DIM};
use crate::model::Model;

/// The width of the list, and its height, of which more is scrolled.
const LIST: (f32, f32) = (380.0, 232.0);

/// The list of what can be written at the cursor, and the kinds that it knows.
#[derive(Default)]
pub(super) struct Completion {
    is_open: bool,
    /// The entry that Enter takes.
    present: usize,
    /// A key has moved the present entry.
    is_moved: bool,
    is_entered: bool,
    kinds: Vec<NodeKind>,
    /// The place of the cursor in the text.
    place: TextPlace,
    /// The kind that the cursor was in last, and its port or parameter there.
    described: Option<(String, Option<String>)>,
}

impl Completion {
    /// Takes the keys of the list before the field gets them. Ctrl+Space opens it, and Esc closes it. Returns true for
    /// the latter: the field has lost the keyboard.
    pub(super) fn keys(&mut self, ui: &Ui, model: &Model, has_focus: bool) -> bool {
        let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
        if has_focus && pressed(Modifiers::CTRL, Key::Space) {
            (self.is_open, self.present) = (true, 0);
            self.kinds = model.kinds().unwrap_or_default();
        }
        if !self.is_open {
            return false;
        }
        let plain = |key| pressed(Modifiers::NONE, key);
        let (is_down, is_up) = (plain(Key::ArrowDown), plain(Key::ArrowUp));
        self.present = if is_up { self.present.saturating_sub(1) } else { self.present + usize::from(is_down) };
        self.is_moved = is_down || is_up;
        self.is_entered = plain(Key::Enter) || plain(Key::Tab);
        let is_closed = plain(Key::Escape);
        self.is_open &= !is_closed;
        is_closed
    }

    /// Follows the cursor to another place.
    pub(super) fn follow(&mut self, model: &Model, place: TextPlace) {
        if self.place == place {
            return;
        }
        if self.kinds.is_empty() || self.place.groups.len() != place.groups.len() {
            self.kinds = model.kinds().unwrap_or_default();
        }
        let known = Known { kinds: &self.kinds, graph: model.editor().graph().map(|graph| &**graph) };
        if let Some((kind, field)) = known.described(&place) {
            self.described = Some((kind.name().to_owned(), field));
        }
        (self.place, self.present) = (place, 0);
    }

    /// Shows the list at the cursor, if it is open. Returns what is taken, and the bytes that it replaces.
    pub(super) fn show(
        &mut self,
        ui: &Ui,
        model: &Model,
        output: &TextEditOutput,
    ) -> Option<(Proposal, std::ops::Range<usize>)> {
        let cursor = output.cursor_range.filter(|_| self.is_open)?.primary;
        let known = Known { kinds: &self.kinds, graph: model.editor().graph().map(|graph| &**graph) };
        let mut proposals = known.proposals(&self.place);
        self.present = self.present.min(proposals.len().saturating_sub(1));
        let line = output.galley.pos_from_cursor(cursor).translate(output.galley_pos.to_vec2());
        // The list must not hide what is typed.
        let is_above = line.max.y + LIST.1 + 16.0 > ui.ctx().content_rect().max.y;
        let (pivot, at) = match is_above {
            true => (egui::Align2::LEFT_BOTTOM, line.left_top() - egui::vec2(0.0, 4.0)),
            false => (egui::Align2::LEFT_TOP, line.left_bottom() + egui::vec2(0.0, 4.0)),
        };
        let taken = self.list(ui, &proposals, pivot, at);
        let taken = taken.or((self.is_entered && !proposals.is_empty()).then_some(self.present))?;
        self.is_open = false;
        Some((proposals.swap_remove(taken), self.place.token.clone()))
    }

    fn list(&mut self, ui: &Ui, proposals: &[Proposal], pivot: egui::Align2, at: Pos2) -> Option<usize> {
        let area = Area::new(Id::new("completion")).order(Order::Foreground).pivot(pivot).fixed_pos(at);
        let shown = area.constrain(true).fade_in(false).show(ui.ctx(), |ui| {
            Frame::menu(ui.style()).show(ui, |ui| {
                ui.set_width(LIST.0);
                if proposals.is_empty() {
                    ui.label(RichText::new("Nothing that is known fits here.").color(DIM));
                }
                let mut taken = None;
                ScrollArea::vertical().max_height(LIST.1).show(ui, |ui| {
                    ui.with_layout(egui::Layout::top_down_justified(egui::Align::LEFT), |ui| {
                        for (index, proposal) in proposals.iter().enumerate() {
                            let text = entry(&proposal.name, &proposal.detail, &proposal.doc);
                            let entry = ui.add(Button::selectable(index == self.present, text).wrap());
                            if entry.clicked() {
                                taken = Some(index);
                            }
                            if index == self.present && self.is_moved {
                                entry.scroll_to_me(None);
                            }
                        }
                    });
                });
                taken
            })
        });
        let pressed = ui.input(|input| input.pointer.any_pressed().then(|| input.pointer.interact_pos()).flatten());
        self.is_open &= pressed.is_none_or(|at| shown.response.rect.contains(at));
        shown.inner.inner
    }

    /// Shows the manual of the kind that the cursor is in: the port or parameter at the cursor first.
    pub(super) fn docs(&self, ui: &mut Ui) {
        let described = self.described.as_ref();
        let kind = described.and_then(|(name, _)| self.kinds.iter().find(|kind| kind.name() == *name));
        let Some((kind, (_, field))) = kind.zip(described) else {
            let text = "The manual of the kind that the cursor is in is shown here.\nCtrl+Space lists what can be \
                        written at the cursor: kinds, ports, parameters, values, wires.";
            ui.add(egui::Label::new(RichText::new(text).color(DIM)).wrap());
            return;
        };
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.label(RichText::new(kind.name()).strong());
            ui.add(egui::Label::new(kind.doc().trim().split("\n\n").next().unwrap_or_default()).wrap());
            ui.add_space(4.0);
            let mut lines: Vec<(&str, String, &str)> = Vec::new();
            for input in kind.inputs() {
                let optional = if input.optional { ", may be left out" } else { "" };
                lines.push((&input.name, format!("reads {}{optional}", input.ty.name()), &input.doc));
            }
            lines.extend(kind.params().iter().map(|param| (&*param.name, short_type(param), &*param.doc)));
            for output in kind.outputs() {
                lines.push((&output.name, format!("gives {}", output.ty.name()), &output.doc));
            }
            lines.sort_by_key(|(name, ..)| Some(*name) != field.as_deref());
            for (name, detail, doc) in lines {
                let color = if Some(name) == field.as_deref() { ACCENT } else { Color32::from_gray(0xe4) };
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(name).color(color));
                    ui.label(RichText::new(detail).color(DIM).small());
                });
                ui.add(egui::Label::new(RichText::new(doc.trim()).small()).wrap());
            }
        });
    }
}
