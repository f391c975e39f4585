//! One diagnostic, and the list of all diagnostics with the texts that they point into.

use serde::Serialize;

use super::location::Location;
use super::sources::Sources;

/// How severe a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file cannot be used.
    Error,
    /// The file can be used, but probably does not mean what its author intends.
    Warning,
}

/// A remark at a location.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The location.
    pub location: Location,
    /// What the location shows; may be empty.
    pub text: String,
    /// Whether this is the location of the error, not one that explains it.
    pub primary: bool,
}

/// An error or a warning.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// A stable name in kebab case.
    pub code: &'static str,
    /// The severity.
    pub severity: Severity,
    /// What is wrong: lower case, no full stop.
    pub message: String,
    /// The locations, the primary one first.
    pub labels: Vec<Label>,
    /// A hint: what to do about it.
    pub help: Option<String>,
}

impl Diagnostic {
    fn new(code: &'static str, severity: Severity, message: impl Into<String>) -> Self {
        Self { code, severity, message: message.into(), labels: Vec::new(), help: None }
    }

    /// An error.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Error, message)
    }

    /// A warning.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, message)
    }

    /// Adds the location of the error.
    pub fn at(mut self, location: &Location, text: impl Into<String>) -> Self {
        self.labels.push(Label { location: location.clone(), text: text.into(), primary: true });
        self
    }

    /// Adds a location that explains the error.
    pub fn also(mut self, location: &Location, text: impl Into<String>) -> Self {
        self.labels.push(Label { location: location.clone(), text: text.into(), primary: false });
        self
    }

    /// Sets the hint.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Sets the hint if there is one; otherwise the present one stays.
    pub fn maybe_help(mut self, text: Option<String>) -> Self {
        self.help = text.or(self.help);
        self
    }

    fn order(&self, sources: &Sources) -> (usize, usize, Severity, &'static str) {
        match self.labels.first() {
            Some(label) => (sources.rank(&label.location.file), label.location.start, self.severity, self.code),
            None => (0, 0, self.severity, self.code),
        }
    }
}

/// All diagnostics, with the texts that their locations point into.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    /// The texts of the files.
    pub sources: Sources,
}

impl Diagnostics {
    /// No diagnostics yet for these files.
    pub fn new(sources: Sources) -> Self {
        Self { list: Vec::new(), sources }
    }

    /// Adds a diagnostic.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Adds the diagnostics and the files of another list.
    pub fn absorb(&mut self, other: Self) {
        self.sources.absorb(other.sources);
        self.list.extend(other.list);
    }

    /// Adds a text that diagnostics may point into.
    pub fn add_source(&mut self, file: &str, text: &str) {
        self.sources.insert(file, text);
    }

    /// The location of a line and a column of a text that was added, both counted from 1.
    pub fn locate(&self, file: &str, line: u32, column: u32) -> Option<Location> {
        self.sources.line(file, line, column)
    }

    /// Sorts by location and removes duplicates.
    pub fn sorted(mut self) -> Self {
        let sources = &self.sources;
        self.list.sort_by(|a, b| a.order(sources).cmp(&b.order(sources)).then_with(|| a.message.cmp(&b.message)));
        self.list.dedup();
        self
    }

    /// Whether any is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Iterates over the diagnostics.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// The number of diagnostics.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no diagnostics.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
