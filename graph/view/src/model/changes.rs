//! The text and the values of a pipeline as the user has left them, with one history of both.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::{Change, Graph};
use afterimage_graph::value::Value;

/// Something in the graph that has a control.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A parameter, `node.parameter`.
    Parameter(String),
    /// The switch of a node.
    Node(String),
}

impl Target {
    /// `node.parameter`, or the name of the node.
    pub fn name(&self) -> &str {
        match self {
            Self::Parameter(name) | Self::Node(name) => name,
        }
    }

    /// The value that the text of a graph gives it.
    pub fn written(&self, graph: &Graph) -> Option<Value> {
        match self {
            Self::Parameter(name) => Some(graph.value(graph.parameter(name).ok()?).clone()),
            Self::Node(name) => Some(Value::Bool(!graph.node(name)?.1.off)),
        }
    }

    /// The change to save for this value.
    pub fn change(&self, value: &Value) -> Change {
        match self {
            Self::Parameter(name) => Change::Value { parameter: name.clone(), value: value.clone() },
            Self::Node(name) => Change::Enabled { node: name.clone(), on: *value == Value::Bool(true) },
        }
    }
}

/// One moment of the history.
#[derive(Clone, Debug, Default, PartialEq)]
struct State {
    text: Arc<str>,
    tier: Option<String>,
    /// Values that differ from those of the text.
    values: BTreeMap<Target, Value>,
}

/// The difference that an undo or a redo makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Restored {
    /// The text, and with it any value.
    Text,
    Values(Vec<Target>),
}

/// The text and the values that are shown, what the file has, and the states to which undo and redo go.
#[derive(Default)]
pub struct Changes {
    present: State,
    /// The text of the file.
    written: Arc<str>,
    done: Vec<State>,
    undone: Vec<State>,
    /// The control that is being dragged: its next change belongs to the same step.
    dragged: Option<Target>,
}

impl Changes {
    /// A text as the file has it.
    pub fn new(text: &str) -> Self {
        let text: Arc<str> = text.into();
        Self { present: State { text: text.clone(), ..State::default() }, written: text, ..Self::default() }
    }

    /// The text that is shown, without the changed values.
    pub fn text(&self) -> &str {
        &self.present.text
    }

    /// The text of the file.
    pub fn written(&self) -> &str {
        &self.written
    }

    /// The tier that is shown.
    pub fn tier(&self) -> Option<&str> {
        self.present.tier.as_deref()
    }

    /// Shows another tier, which is no step of the history.
    pub fn set_tier(&mut self, tier: Option<String>) {
        self.present.tier = tier;
    }

    /// The value that the user has set.
    pub fn get(&self, target: &Target) -> Option<&Value> {
        self.present.values.get(target)
    }

    /// True if everything is in the file.
    pub fn is_empty(&self) -> bool {
        self.present.values.is_empty() && !self.is_text_changed()
    }

    /// True if the text differs from that of the file.
    pub fn is_text_changed(&self) -> bool {
        self.present.text != self.written
    }

    /// The number of changed values.
    pub fn len(&self) -> usize {
        self.present.values.len()
    }

    pub fn iter(&self) -> impl Iterator<Item = (&Target, &Value)> {
        self.present.values.iter()
    }

    /// Sets a value; `None` is the value of the text. Changes of one target until [`release`](Self::release) are one
    /// step.
    pub fn set(&mut self, target: &Target, value: Option<Value>) {
        if self.present.values.get(target) == value.as_ref() {
            return;
        }
        if self.dragged.as_ref() != Some(target) {
            self.begin_step();
        }
        self.undone.clear();
        match value {
            Some(value) => drop(self.present.values.insert(target.clone(), value)),
            None => drop(self.present.values.remove(target)),
        }
        self.dragged = Some(target.clone());
    }

    /// Sets several values in one step; `None` is the value of the text.
    pub fn set_together(&mut self, values: Vec<(Target, Option<Value>)>) {
        if values.iter().all(|(target, value)| self.present.values.get(target) == value.as_ref()) {
            return;
        }
        self.begin_step();
        for (target, value) in values {
            match value {
                Some(value) => drop(self.present.values.insert(target, value)),
                None => drop(self.present.values.remove(&target)),
            }
        }
    }

    /// True while a control is being dragged.
    pub fn is_dragging(&self) -> bool {
        self.dragged.is_some()
    }

    /// Ends a drag: the next change is another step.
    pub fn release(&mut self) {
        self.dragged = None;
    }

    pub fn edit(&mut self, text: &str) {
        if *self.present.text != *text {
            self.begin_step();
            self.present.text = text.into();
        }
    }

    /// Replaces the text after an edit of the graph, in one step. `name_after` gives the names of parameters and nodes
    /// after it; `None` if they are gone, with their changed values.
    pub fn edit_graph(&mut self, text: &str, name_after: impl Fn(&str) -> Option<String>) {
        self.begin_step();
        self.present.text = text.into();
        let kept = std::mem::take(&mut self.present.values).into_iter().filter_map(|(target, value)| {
            let name = name_after(target.name())?;
            let target = match target {
                Target::Parameter(_) => Target::Parameter(name),
                Target::Node(_) => Target::Node(name),
            };
            Some((target, value))
        });
        self.present.values = kept.collect();
    }

    /// Takes back the values of these targets in one step.
    pub fn revert(&mut self, targets: &[Target]) {
        self.begin_step();
        self.present.values.retain(|target, _| !targets.contains(target));
    }

    /// Removes a value that the text has by itself now. That is no step.
    pub fn forget(&mut self, target: &Target) {
        self.present.values.remove(target);
    }

    /// The file has another text. It replaces the file's text before in the whole history, so that undo takes back what
    /// the user has done and not what another program has written.
    pub fn set_written(&mut self, text: &str) {
        let text: Arc<str> = text.into();
        let before = std::mem::replace(&mut self.written, text.clone());
        for state in self.done.iter_mut().chain(&mut self.undone).chain([&mut self.present]) {
            if state.text == before {
                state.text = text.clone();
            }
        }
    }

    /// The file has this text now, in which the changed values are. Undo goes back to the text before.
    pub fn save(&mut self, text: &str, tier: Option<String>) {
        if *self.present.text != *text || !self.present.values.is_empty() {
            self.begin_step();
        }
        self.present = State { text: text.into(), tier, values: BTreeMap::new() };
        self.written = self.present.text.clone();
    }

    /// The file has the present text now, without the changed values.
    pub fn save_text(&mut self) {
        self.written = self.present.text.clone();
    }

    /// The present text, tier and values, without a history.
    pub fn snapshot(&self) -> Self {
        Self { present: self.present.clone(), written: self.written.clone(), ..Self::default() }
    }

    /// True if the text, the tier and the values are those of a snapshot.
    pub fn shows(&self, snapshot: &Self) -> bool {
        self.present == snapshot.present
    }

    /// Goes to the text, the tier and the values of a snapshot, in one step.
    pub(super) fn go_to(&mut self, snapshot: &Self) {
        self.begin_step();
        self.present = snapshot.present.clone();
    }

    /// Goes back by one step.
    pub fn undo(&mut self) -> Option<Restored> {
        let state = self.done.pop()?;
        let (before, restored) = self.restore(state);
        self.undone.push(before);
        Some(restored)
    }

    /// Takes the step again that was taken back last.
    pub fn redo(&mut self) -> Option<Restored> {
        let state = self.undone.pop()?;
        let (before, restored) = self.restore(state);
        self.done.push(before);
        Some(restored)
    }

    /// True if there is a step to take back.
    pub fn can_undo(&self) -> bool {
        !self.done.is_empty()
    }

    /// True if there is a step to take again.
    pub fn can_redo(&self) -> bool {
        !self.undone.is_empty()
    }

    fn begin_step(&mut self) {
        self.done.push(self.present.clone());
        self.undone.clear();
        self.dragged = None;
    }

    /// Replaces the present state, and returns it with the difference.
    fn restore(&mut self, mut state: State) -> (State, Restored) {
        self.dragged = None;
        if state.text == self.present.text {
            // The tiers are the same, and the user has chosen one.
            state.tier.clone_from(&self.present.tier);
        }
        let before = std::mem::replace(&mut self.present, state);
        if before.text != self.present.text {
            return (before, Restored::Text);
        }
        let targets = before.values.keys().chain(self.present.values.keys());
        let mut differing: Vec<Target> =
            targets.filter(|target| before.values.get(target) != self.present.values.get(target)).cloned().collect();
        differing.sort();
        differing.dedup();
        (before, Restored::Values(differing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strength() -> Target {
        Target::Parameter("lit.strength".into())
    }

    fn only(target: Target) -> Option<Restored> {
        Some(Restored::Values(vec![target]))
    }

    #[test]
    fn a_held_slider_is_one_step_and_undo_goes_back_to_the_file() {
        let mut changes = Changes::default();
        for value in [0.1, 0.2, 0.3] {
            changes.set(&strength(), Some(Value::Float(value)));
        }
        changes.release();
        changes.set(&strength(), Some(Value::Float(0.5)));
        changes.release();
        assert_eq!(changes.get(&strength()), Some(&Value::Float(0.5)));
        assert_eq!(changes.undo(), only(strength()));
        assert_eq!(changes.get(&strength()), Some(&Value::Float(0.3)));
        assert_eq!(changes.undo(), only(strength()));
        assert_eq!((changes.get(&strength()), changes.can_undo(), changes.can_redo()), (None, false, true));
        assert_eq!(changes.redo(), only(strength()));
        assert_eq!(changes.get(&strength()), Some(&Value::Float(0.3)));
    }

    #[test]
    fn a_new_change_ends_what_can_be_taken_again() {
        let mut changes = Changes::default();
        changes.set(&strength(), Some(Value::Float(0.1)));
        changes.release();
        changes.undo();
        changes.set(&Target::Node("grain".into()), Some(Value::Bool(false)));
        assert_eq!((changes.redo(), changes.len()), (None, 1));
    }

    #[test]
    fn the_same_value_again_is_no_step() {
        let mut changes = Changes::default();
        changes.set(&strength(), Some(Value::Float(0.1)));
        changes.release();
        changes.set(&strength(), Some(Value::Float(0.1)));
        changes.undo();
        assert_eq!((changes.is_empty(), changes.can_undo(), changes.can_redo()), (true, false, true));
    }

    #[test]
    fn text_and_values_are_one_history_that_a_save_does_not_end() {
        let mut changes = Changes::new("a");
        changes.edit("b");
        changes.set(&strength(), Some(Value::Float(0.1)));
        changes.save("b 0.1", None);
        assert!(changes.is_empty());
        assert_eq!(changes.undo(), Some(Restored::Text));
        assert_eq!((changes.text(), changes.len(), changes.is_empty()), ("b", 1, false));
        assert_eq!(changes.undo(), only(strength()));
        assert_eq!(changes.undo(), Some(Restored::Text));
        assert_eq!((changes.text(), changes.can_undo()), ("a", false));
        for _ in 0..3 {
            changes.redo();
        }
        assert!(changes.is_empty() && changes.text() == "b 0.1");
    }

    #[test]
    fn undo_does_not_take_back_what_another_program_has_written() {
        let mut changes = Changes::new("a");
        changes.set(&strength(), Some(Value::Float(0.1)));
        changes.set_written("b");
        assert_eq!((changes.text(), changes.len()), ("b", 1));
        assert_eq!(changes.undo(), only(strength()));
        assert_eq!((changes.text(), changes.is_empty()), ("b", true));
    }
}
