//! Keys.

use egui::{Context, Key, Modifiers};

use super::picture::Comparison;
use super::text::TextPanel;
use super::{ExportKind, Tab, Viewer};
use crate::model::CompareWith;

impl Viewer {
    /// Runs the commands of pressed keys, unless a text is being typed.
    pub(super) fn keys(&mut self, ctx: &Context) {
        let pressed = |modifiers, key| ctx.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::COMMAND, Key::S) {
            self.save(ctx, None);
        }
        if pressed(Modifiers::COMMAND, Key::E) {
            self.export(ExportKind::Picture);
        }
        release_field(ctx);
        // The text and the controls have one history; other fields have their own.
        if !ctx.egui_wants_keyboard_input() || TextPanel::has_focus(ctx) {
            if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
                self.redo();
            }
            if pressed(Modifiers::COMMAND, Key::Z) {
                self.undo();
            }
        }
        if ctx.egui_wants_keyboard_input() {
            return;
        }
        let plain = |key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        self.time_keys(plain);
        self.picture_keys(plain);
        self.tab_keys(plain);
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

    fn time_keys(&mut self, pressed: impl Fn(Key) -> bool) {
        let clock = self.model.clock();
        if pressed(Key::Space) {
            clock.is_playing = !clock.is_playing;
        }
        if pressed(Key::Period) {
            clock.step();
        }
        if pressed(Key::C) {
            clock.cut();
        }
    }

    fn picture_keys(&mut self, pressed: impl Fn(Key) -> bool) {
        if pressed(Key::F) {
            self.picture.zoom = None;
        }
        if pressed(Key::Num1) {
            self.picture.zoom = Some(1.0);
        }
        let modes = [(Key::W, Comparison::Wipe), (Key::B, Comparison::SideBySide), (Key::D, Comparison::Difference)];
        for (key, mode) in modes {
            if pressed(key) {
                self.picture.comparison = mode;
                if self.model.compared().is_none() {
                    self.model.set_compared(Some(CompareWith::Written));
                }
            }
        }
        if pressed(Key::R) {
            let is_reference = self.model.compared() == Some(&CompareWith::Reference);
            self.model.set_compared(if is_reference { None } else { Some(CompareWith::Reference) });
        }
        if pressed(Key::Escape) {
            self.model.set_tap(None);
        }
    }

    fn tab_keys(&mut self, pressed: impl Fn(Key) -> bool) {
        let tabs = [(Key::G, Tab::Graph), (Key::T, Tab::Text), (Key::K, Tab::Cost), (Key::M, Tab::Messages)];
        for (key, tab) in tabs {
            if pressed(key) {
                self.tab = if self.tab == Some(tab) { None } else { Some(tab) };
            }
        }
        if pressed(Key::S) {
            self.shows_scopes = !self.shows_scopes;
        }
        if pressed(Key::P) {
            self.shows_probe = !self.shows_probe;
        }
        if pressed(Key::H) {
            self.is_bare = !self.is_bare;
        }
        if pressed(Key::F1) {
            self.shows_help = !self.shows_help;
        }
    }
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
