//! What is wrong with a kind.

/// The violations of one kind that were found so far, each once.
#[derive(Default)]
pub(super) struct Violations(pub(super) Vec<String>);

impl Violations {
    pub(super) fn add(&mut self, violation: impl Into<String>) {
        let violation = violation.into();
        if !self.0.contains(&violation) {
            self.0.push(violation);
        }
    }

    /// Adds a violation unless the condition holds.
    pub(super) fn require(&mut self, holds: bool, violation: impl FnOnce() -> String) {
        if !holds {
            self.add(violation());
        }
    }
}
