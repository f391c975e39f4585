//! The list of violations of the contract.

/// The violations that were found so far, each once.
#[derive(Default)]
pub(super) struct Violations {
    kind: String,
    all: Vec<String>,
    skipped: Vec<String>,
    /// Those of kinds before the present one.
    earlier: usize,
}

impl Violations {
    /// Later violations belong to this kind.
    pub(super) fn about(&mut self, kind: &str) {
        self.kind = kind.to_owned();
        self.earlier = self.all.len();
    }

    /// Adds a violation of the present kind.
    pub(super) fn add(&mut self, what: impl std::fmt::Display) {
        let violation = format!("`{}`: {what}", self.kind);
        if !self.all.contains(&violation) {
            self.all.push(violation);
        }
    }

    /// How many the present kind has.
    pub(super) fn of_kind(&self) -> usize {
        self.all.len() - self.earlier
    }

    /// Adds a violation unless the condition holds.
    pub(super) fn require(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.add(what());
        }
    }

    /// Adds what cannot be checked of the present kind.
    pub(super) fn skip(&mut self, what: impl std::fmt::Display) {
        self.skipped.push(format!("`{}`: {what}", self.kind));
    }

    /// All violations; if there are none, what was skipped.
    pub(super) fn finish(self) -> Result<Vec<String>, Vec<String>> {
        if self.all.is_empty() { Ok(self.skipped) } else { Err(self.all) }
    }
}
