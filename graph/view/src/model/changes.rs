//! What a user has changed since the pipeline was written, with undo and redo.

use std::collections::BTreeMap;

use afterimage_graph::check::Change;
use afterimage_graph::value::Value;

/// Something that a user changes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A parameter, `node.parameter`.
    Parameter(String),
    /// Whether a node runs.
    Node(String),
}

impl Target {
    /// What is saved if it has this value.
    pub fn change(&self, value: &Value) -> Change {
        match self {
            Self::Parameter(name) => Change::Value { parameter: name.clone(), value: value.clone() },
            Self::Node(name) => Change::Enabled { node: name.clone(), on: *value == Value::Bool(true) },
        }
    }
}

/// One change: what it was and what it is; `None` is what the file says.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    target: Target,
    before: Option<Value>,
    after: Option<Value>,
}

/// The changes that are not in the file.
#[derive(Default)]
pub struct Changes {
    present: BTreeMap<Target, Value>,
    done: Vec<Step>,
    undone: Vec<Step>,
    /// Whether the last step is still under way: a slider is held.
    is_held: bool,
}

impl Changes {
    /// The value that the user has set.
    pub fn get(&self, target: &Target) -> Option<&Value> {
        self.present.get(target)
    }

    /// Whether nothing is changed.
    pub fn is_empty(&self) -> bool {
        self.present.is_empty()
    }

    /// The number of things that are changed.
    pub fn len(&self) -> usize {
        self.present.len()
    }

    /// All changes.
    pub fn iter(&self) -> impl Iterator<Item = (&Target, &Value)> {
        self.present.iter()
    }

    /// Sets a value, or goes back to that of the file. Changes of one target until [`release`](Self::release) are one
    /// step.
    pub fn set(&mut self, target: &Target, value: Option<Value>) {
        let before = self.present.get(target).cloned();
        if before == value {
            return;
        }
        self.put(target, value.clone());
        self.undone.clear();
        match self.done.last_mut().filter(|step| self.is_held && step.target == *target) {
            Some(step) => step.after = value,
            None => self.done.push(Step { target: target.clone(), before, after: value }),
        }
        self.is_held = true;
    }

    /// The change that was under way is finished.
    pub fn release(&mut self) {
        self.is_held = false;
    }

    /// Takes the last step back, and says what is changed by that.
    pub fn undo(&mut self) -> Option<Target> {
        let step = self.done.pop()?;
        self.put(&step.target, step.before.clone());
        let target = step.target.clone();
        self.undone.push(step);
        Some(target)
    }

    /// Takes the last step again that was taken back.
    pub fn redo(&mut self) -> Option<Target> {
        let step = self.undone.pop()?;
        self.put(&step.target, step.after.clone());
        let target = step.target.clone();
        self.done.push(step);
        Some(target)
    }

    /// Whether there is a step to take back, and one to take again.
    pub fn can(&self) -> (bool, bool) {
        (!self.done.is_empty(), !self.undone.is_empty())
    }

    /// Forgets everything: the changes are in the file, or the file is another one.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn put(&mut self, target: &Target, value: Option<Value>) {
        match value {
            Some(value) => drop(self.present.insert(target.clone(), value)),
            None => drop(self.present.remove(target)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strength() -> Target {
        Target::Parameter("lit.strength".into())
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
        assert_eq!(changes.undo(), Some(strength()));
        assert_eq!(changes.get(&strength()), Some(&Value::Float(0.3)));
        assert_eq!(changes.undo(), Some(strength()));
        assert_eq!((changes.get(&strength()), changes.can()), (None, (false, true)));
        assert_eq!(changes.redo(), Some(strength()));
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
        assert_eq!((changes.is_empty(), changes.can()), (true, (false, true)));
    }
}
