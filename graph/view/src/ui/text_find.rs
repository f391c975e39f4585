//! Finding words in the text of the pipeline.

use std::ops::Range;

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditOutput;
use egui::{Id, Key, Modifiers, Rect, RichText, TextEdit, Ui};

use super::theme::{ACCENT, DIM};

/// The field of a search, and the place that was found last.
#[derive(Default)]
pub(super) struct Find {
    is_open: bool,
    /// It was opened since it was shown last.
    is_new: bool,
    words: String,
    present: usize,
    /// The text scrolls to the present place.
    goes: bool,
}

impl Find {
    pub(super) fn open(&mut self) {
        (self.is_open, self.is_new) = (true, true);
    }

    /// Shows the field over the text. Enter goes to the next place, with Shift to the one before. Returns true when Esc
    /// closes it: the keyboard is that of the text then, where the cursor is behind the last place.
    pub(super) fn show(&mut self, ui: &mut Ui, text: &str) -> bool {
        if !self.is_open {
            return false;
        }
        if ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            self.is_open = false;
            return true;
        }
        let count = places(text, &self.words).len();
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.words).id(Id::new("find in the text")).hint_text("Find");
            let field = ui.add(field.desired_width(220.0));
            if std::mem::take(&mut self.is_new) {
                field.request_focus();
            }
            let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let is_back = is_entered && ui.input(|input| input.modifiers.shift);
            if is_entered {
                field.request_focus();
            }
            if field.changed() {
                (self.present, self.goes) = (0, true);
            } else if is_entered && count > 0 {
                self.present = (self.present + if is_back { count - 1 } else { 1 }) % count;
                self.goes = true;
            }
            let found = match count {
                0 if self.words.is_empty() => String::new(),
                0 => "not found".to_owned(),
                count => format!("{} of {count}", self.present.min(count - 1) + 1),
            };
            ui.label(RichText::new(found).color(DIM));
        });
        false
    }

    /// Marks the places in the text that is shown, and goes to the present one.
    pub(super) fn mark(&mut self, ui: &Ui, output: &TextEditOutput, text: &str) {
        if !self.is_open {
            return;
        }
        for (index, place) in places(text, &self.words).into_iter().enumerate() {
            let [from, to] = [place.start, place.end].map(|at| {
                let rect = output.galley.pos_from_cursor(CCursor::new(at));
                rect.translate(output.galley_pos.to_vec2())
            });
            let is_present = index == self.present;
            let rect = Rect::from_min_max(from.min, to.max);
            ui.painter().rect_filled(rect, 2.0, ACCENT.gamma_multiply_u8(if is_present { 0x60 } else { 0x30 }));
            if is_present && std::mem::take(&mut self.goes) {
                let mut state = output.state.clone();
                state
                    .cursor
                    .set_char_range(Some(CCursorRange::two(CCursor::new(place.start), CCursor::new(place.end))));
                state.store(ui.ctx(), output.response.id);
                ui.scroll_to_rect(rect, Some(egui::Align::Center));
            }
        }
    }
}

/// Places of words in a text, counted in letters. Small letters and capitals are alike.
fn places(text: &str, words: &str) -> Vec<Range<usize>> {
    let small = |c: char| c.to_lowercase().next().unwrap_or(c);
    let (text, words): (Vec<char>, Vec<char>) = (text.chars().map(small).collect(), words.chars().map(small).collect());
    if words.is_empty() {
        return Vec::new();
    }
    let found = text.windows(words.len()).enumerate().filter(|(_, window)| *window == words);
    found.map(|(start, _)| start..start + words.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::places;

    #[test]
    fn words_are_found_whatever_their_case_and_letters() {
        assert_eq!(places("Ann\u{ef}e: \u{c4}nn", "\u{e4}nn").as_slice(), std::slice::from_ref(&(7..10)));
        assert_eq!(places("aAa", "A"), [0..1, 1..2, 2..3]);
        assert!(places("abc", "").is_empty() && places("ab", "abc").is_empty());
    }
}
