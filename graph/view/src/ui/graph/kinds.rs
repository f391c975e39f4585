//! The list of kinds for a new node, which is searched by words.

use afterimage_graph::node::NodeKind;
use egui::text::LayoutJob;
use egui::{Button, Key, Modifiers, RichText, ScrollArea, TextEdit, Ui};

use super::super::entry::entry;
use super::super::theme::{ACCENT, DIM};

/// Kinds, and the words that are searched in them.
pub(super) struct KindList {
    kinds: Vec<NodeKind>,
    /// Those that fit elsewhere alone, which are shown if no other has the words.
    others: Vec<NodeKind>,
    search: String,
    /// The entry that Enter takes.
    present: usize,
}

impl KindList {
    pub(super) fn new(kinds: Vec<NodeKind>, others: Vec<NodeKind>) -> Self {
        Self { kinds, others, search: String::new(), present: 0 }
    }

    /// Shows the field and the list. Returns the kind that is taken, by a click or by Enter.
    pub(super) fn show(&mut self, ui: &mut Ui, is_new: bool, height: f32) -> Option<TakenKind> {
        let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        let (is_down, is_up, is_entered) = (pressed(Key::ArrowDown), pressed(Key::ArrowUp), pressed(Key::Enter));
        let hint = "Find a kind: blur, bloom, grain…";
        let field = ui.add(TextEdit::singleline(&mut self.search).hint_text(hint).desired_width(f32::INFINITY));
        if is_new {
            field.request_focus();
        }
        let fitting = found(&self.kinds, &self.search);
        let is_elsewhere = fitting.is_empty() && !self.search.is_empty();
        let found = if is_elsewhere { found(&self.others, &self.search) } else { fitting };
        self.present = match (is_down, is_up) {
            _ if field.changed() => 0,
            (true, _) => self.present + 1,
            (_, true) => self.present.saturating_sub(1),
            _ => self.present,
        };
        self.present = self.present.min(found.len().saturating_sub(1));
        if found.is_empty() {
            let text = if self.kinds.is_empty() { "No kind fits here." } else { "No kind has these words." };
            ui.label(RichText::new(text).color(DIM));
        } else if is_elsewhere {
            let text = "Not on this wire. It is inserted on the nearest one that takes it:";
            ui.label(RichText::new(text).color(ACCENT).small());
        }
        let mut taken = found.get(self.present).filter(|_| is_entered).map(|kind| kind.name().to_owned());
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            for (index, kind) in found.iter().enumerate() {
                let entry = ui.add(Button::selectable(index == self.present, entry_of(kind)).wrap());
                if entry.clicked() {
                    taken = Some(kind.name().to_owned());
                }
                if index == self.present && (is_down || is_up) {
                    entry.scroll_to_me(None);
                }
                entry.on_hover_text(kind.doc());
            }
        });
        taken.map(|name| TakenKind { name, is_elsewhere })
    }
}

/// A kind that was taken.
pub(super) struct TakenKind {
    pub(super) name: String,
    /// It does not fit where it was asked for.
    pub(super) is_elsewhere: bool,
}

/// The kinds that have all words of a search, those with the words in their names first.
fn found<'k>(kinds: &'k [NodeKind], search: &str) -> Vec<&'k NodeKind> {
    let search = search.to_lowercase();
    let has_all = |text: &str| search.split_whitespace().all(|word| text.contains(word));
    let rank = |kind: &NodeKind| {
        let name = kind.name().to_lowercase();
        if name.starts_with(search.trim()) {
            Some(0)
        } else if has_all(&name) {
            Some(1)
        } else {
            has_all(&format!("{name} {}", kind.doc().to_lowercase())).then_some(2)
        }
    };
    let mut found: Vec<(usize, &NodeKind)> = kinds.iter().filter_map(|kind| Some((rank(kind)?, kind))).collect();
    found.sort_by_key(|(rank, kind)| (*rank, kind.name()));
    found.into_iter().map(|(_, kind)| kind).collect()
}

/// A kind with its ports, and one sentence about it.
fn entry_of(kind: &NodeKind) -> LayoutJob {
    let inputs: Vec<&str> = kind.inputs().iter().filter(|input| !input.optional).map(|input| &*input.name).collect();
    let outputs: Vec<&str> = kind.outputs().iter().map(|output| &*output.name).collect();
    entry(kind.name(), &format!("{} → {}", inputs.join(", "), outputs.join(", ")), kind.doc())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_before_descriptions_and_all_words_are_found() {
        let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
        let kinds: Vec<NodeKind> = registry.iter().cloned().collect();
        let names = |search: &str| found(&kinds, search).iter().map(|kind| kind.name().to_owned()).collect::<Vec<_>>();
        assert_eq!(names("").len(), kinds.len());
        assert_eq!(names("vign")[0], "Vignette");
        assert_eq!(names("grain film")[0], "FilmGrain");
        assert!(names("xyzzy").is_empty());
        assert!(names("bloom").len() > 1);
    }
}
