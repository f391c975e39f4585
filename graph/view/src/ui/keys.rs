//! Keyboard commands.

use egui::{Context, Event, Key, Modifiers, Popup};

use super::graph::GraphPanel;
use super::picture::{Comparison, PictureView};
use super::text::TextPanel;
use super::{ExportKind, Tab, Viewer};
use crate::model::{CompareWith, Model, PlayClock, Slot};

impl Viewer {
    /// Runs the commands of pressed keys. Those without Ctrl are commands while the picture has the focus alone: a
    /// letter that misses its field does nothing.
    pub(super) fn keys(&mut self, ctx: &Context) {
        let pressed = |modifiers, key| ctx.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::S) {
            self.save_as(ctx);
        }
        if pressed(Modifiers::COMMAND, Key::S) {
            self.save(ctx);
        }
        if pressed(Modifiers::COMMAND, Key::E) {
            self.export(ExportKind::Picture);
        }
        if self.tabs.open == Some(Tab::Text) && pressed(Modifiers::COMMAND, Key::F) {
            self.text.open_find();
        }
        release_field(ctx);
        if pressed(Modifiers::NONE, Key::F1) {
            self.shows_help = !self.shows_help;
        }
        // The text, the graph and the controls have one history; other fields have their own.
        if !ctx.egui_wants_keyboard_input() || TextPanel::has_focus(ctx) || GraphPanel::has_focus(ctx) {
            if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
                self.redo();
            }
            if pressed(Modifiers::COMMAND, Key::Z) {
                self.undo();
            }
        }
        // A field, a button that Tab has reached, a menu or a question gets the keys.
        let is_taken =
            ctx.egui_wants_keyboard_input() || Popup::is_any_open(ctx) || self.asks() || self.graph.is_busy();
        if is_taken {
            return;
        }
        if self.snapshot_keys(ctx) || end_choice(ctx, &mut self.picture) {
            return;
        }
        let plain = |key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        self.picture.has_focus |= plain(Key::Escape);
        if !self.picture.has_focus {
            let is_text = |event: &Event| matches!(event, Event::Text(_));
            if ctx.input(|input| input.events.iter().any(is_text)) {
                self.tell(ctx, "Letters are commands while the picture has the focus: click it, or press Esc.");
            }
            return;
        }
        time_keys(self.model.clock(), plain);
        picture_keys(&mut self.model, &mut self.picture, plain);
        if plain(Key::E) {
            self.measurement.request();
        }
        self.panel_keys(plain);
    }

    /// Takes the last change of the text or of a control back.
    pub(super) fn undo(&mut self) {
        self.text.apply(&mut self.model);
        self.model.undo();
    }

    /// Makes the change again that was taken back last.
    pub(super) fn redo(&mut self) {
        self.text.apply(&mut self.model);
        self.model.redo();
    }

    /// Takes a snapshot with Ctrl, compares with it with Alt, goes back to it with both. Returns true for such a key.
    fn snapshot_keys(&mut self, ctx: &Context) -> bool {
        for (key, slot) in [(Key::Num1, Slot::A), (Key::Num2, Slot::B)] {
            let pressed = |modifiers| ctx.input_mut(|input| input.consume_key(modifiers, key));
            let none = || format!("There is no snapshot {}: Ctrl+{} takes it.", slot.name(), key.name());
            if pressed(Modifiers::COMMAND | Modifiers::ALT) {
                self.text.apply(&mut self.model);
                let is_done = self.model.go_to_snapshot(slot);
                self.tell(ctx, if is_done { format!("As in snapshot {}", slot.name()) } else { none() });
            } else if pressed(Modifiers::COMMAND) {
                self.text.apply(&mut self.model);
                self.model.take_snapshot(slot);
                self.tell(ctx, format!("Snapshot {}: Alt+{} compares with it", slot.name(), key.name()));
            } else if pressed(Modifiers::ALT) {
                let other = CompareWith::Snapshot(slot);
                let is_shown = self.model.compared() == Some(&other);
                match self.model.editor().snapshot(slot) {
                    Some(_) => self.model.set_compared((!is_shown).then_some(other)),
                    None => self.tell(ctx, none()),
                }
            } else {
                continue;
            }
            return true;
        }
        false
    }

    fn panel_keys(&mut self, pressed: impl Fn(Key) -> bool) {
        let tabs = [(Key::G, Tab::Graph), (Key::T, Tab::Text), (Key::K, Tab::Cost), (Key::M, Tab::Messages)];
        tabs.into_iter().filter(|(key, _)| pressed(*key)).for_each(|(_, tab)| self.tabs.toggle(tab));
        let switches =
            [(Key::S, &mut self.shows_scopes), (Key::P, &mut self.inspects_pixels), (Key::H, &mut self.is_bare)];
        switches.into_iter().filter(|(key, _)| pressed(*key)).for_each(|(_, is_on)| *is_on = !*is_on);
    }
}

fn time_keys(clock: &mut PlayClock, pressed: impl Fn(Key) -> bool) {
    if pressed(Key::Space) {
        clock.is_playing = !clock.is_playing;
    }
    if pressed(Key::Period) {
        clock.step();
    }
    if pressed(Key::C) {
        clock.cut();
    }
    for (index, key) in [Key::I, Key::O].into_iter().enumerate() {
        if pressed(key) {
            clock.mark(index);
        }
    }
}

fn picture_keys(model: &mut Model, picture: &mut PictureView, pressed: impl Fn(Key) -> bool) {
    if pressed(Key::F) {
        picture.zoom = None;
    }
    if pressed(Key::Num1) {
        picture.zoom = Some(1.0);
    }
    let modes = [(Key::W, Comparison::Wipe), (Key::B, Comparison::SideBySide), (Key::D, Comparison::Difference)];
    for (_, mode) in modes.into_iter().filter(|(key, _)| pressed(*key)) {
        picture.comparison = mode;
        if model.compared().is_none() {
            model.set_compared(Some(CompareWith::Written));
        }
    }
    if pressed(Key::R) {
        let is_reference = model.compared() == Some(&CompareWith::Reference);
        model.set_compared(if is_reference { None } else { Some(CompareWith::Reference) });
    }
    if pressed(Key::Escape) {
        model.inspect_wire(None);
    }
}

/// Esc ends the choice of what should be gray. Returns true if there was one.
fn end_choice(ctx: &Context, picture: &mut PictureView) -> bool {
    let is_ended = picture.picks.is_some() && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
    is_ended && picture.picks.take().is_some()
}

/// A press outside of the focused field takes the keyboard from it. Without this, a field keeps them while a
/// slider is dragged, and after it.
fn release_field(ctx: &Context) {
    let Some(pressed) = ctx.input(|input| input.pointer.any_pressed().then(|| input.pointer.interact_pos())) else {
        return;
    };
    let Some(field) = ctx.memory(|memory| memory.focused()) else { return };
    let is_inside = |at| ctx.read_response(field).is_some_and(|response| response.rect.contains(at));
    if !pressed.is_some_and(is_inside) {
        ctx.memory_mut(|memory| memory.surrender_focus(field));
    }
}
