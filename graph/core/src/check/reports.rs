//! Diagnostics of a check: an error for each limit, and hints while there are few errors.

use afterimage_base::diagnostic::{Diagnostic, Diagnostics};

/// Errors after which names are no longer listed and suggested: each hint looks at all of them.
const MAX_HINTS: usize = 100;

#[derive(Default)]
pub(super) struct Reports {
    pub(super) diagnostics: Diagnostics,
    /// Codes of the limits beyond which an error has been reported.
    limits: Vec<&'static str>,
}

impl Reports {
    pub(super) fn new(diagnostics: Diagnostics) -> Self {
        Self { diagnostics, limits: Vec::new() }
    }

    pub(super) fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Adds the error of a limit, the first time that it is exceeded.
    pub(super) fn push_limit(&mut self, error: Diagnostic) {
        if !self.limits.contains(&error.code) {
            self.limits.push(error.code);
            self.push(error);
        }
    }

    /// Returns whether further errors get no hints.
    pub(super) fn are_many(&self) -> bool {
        self.diagnostics.len() >= MAX_HINTS
    }

    /// The diagnostic with the nearest of the names as a hint, unless there are many errors: all names are compared.
    pub(super) fn with_nearest<'n>(
        &self,
        diagnostic: Diagnostic,
        wrong: &str,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Diagnostic {
        if self.are_many() { diagnostic } else { diagnostic.did_you_mean(wrong, names) }
    }
}
