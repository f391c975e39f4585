//! Diagnostics: what is wrong with a user's files, where, and what to do about it.
//!
//! Every mistake in a user's file becomes a [`Diagnostic`] with a stable code, one or more places and, where one is known, a hint.
//! [`Diagnostics`] holds all of them together with the texts they point into, so that it can be printed
//! ([`Diagnostics::render`]) or handed to an editor ([`Diagnostics::to_json`]) without any other help.

mod json;
mod render;
mod sources;

use std::ops::Range;
use std::sync::Arc;

use serde::Serialize;

pub use render::Style;
pub use sources::{Position, Sources};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file cannot be used.
    Error,
    /// The file can be used, but probably says something else than its author means.
    Warning,
}

/// Some bytes of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// The file's name.
    pub file: Arc<str>,
    /// From the first byte.
    pub start: usize,
    /// To the byte after the last.
    pub end: usize,
}

impl Place {
    /// The bytes `span` of `file`.
    pub fn new(file: &Arc<str>, span: Range<usize>) -> Self {
        Self { file: file.clone(), start: span.start, end: span.end.max(span.start) }
    }

    /// The bytes as a range.
    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }

    /// A part of this place, counted from its first byte.
    pub fn part(&self, span: Range<usize>) -> Self {
        Self::new(&self.file, self.start + span.start..self.start + span.end)
    }
}

/// A value and where it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it was written.
    pub place: Place,
}

impl<T> Spanned<T> {
    /// A value at a place.
    pub fn new(value: T, place: Place) -> Self {
        Self { value, place }
    }
}

/// A remark at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Where.
    pub place: Place,
    /// What is to be seen there; may be empty.
    pub text: String,
    /// Whether this is the place of the mistake, not one that explains it.
    pub primary: bool,
}

/// One mistake, or one thing that looks like one.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// A stable name in kebab case.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong: lower case, no full stop.
    pub message: String,
    /// Where, the primary place first.
    pub labels: Vec<Label>,
    /// What to do about it.
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

    /// Adds the place of the mistake.
    pub fn at(mut self, place: &Place, text: impl Into<String>) -> Self {
        self.labels.push(Label { place: place.clone(), text: text.into(), primary: true });
        self
    }

    /// Adds a place that explains the mistake.
    pub fn also(mut self, place: &Place, text: impl Into<String>) -> Self {
        self.labels.push(Label { place: place.clone(), text: text.into(), primary: false });
        self
    }

    /// Says what to do.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Says what to do, if it is known.
    pub fn maybe_help(mut self, text: Option<String>) -> Self {
        self.help = text.or(self.help);
        self
    }

    fn order(&self, sources: &Sources) -> (usize, usize, Severity, &'static str) {
        match self.labels.first() {
            Some(label) => (sources.rank(&label.place.file), label.place.start, self.severity, self.code),
            None => (0, 0, self.severity, self.code),
        }
    }
}

/// All that is wrong, in the order of the files and places, with the texts that the places point into.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    /// The texts of the files.
    pub sources: Sources,
}

impl Diagnostics {
    /// Nothing wrong so far with these files.
    pub fn new(sources: Sources) -> Self {
        Self { list: Vec::new(), sources }
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Adds all of another set, and its files.
    pub fn absorb(&mut self, other: Self) {
        self.sources.absorb(other.sources);
        self.list.extend(other.list);
    }

    /// Adds a text that diagnostics may point into.
    pub fn add_source(&mut self, file: &str, text: &str) {
        self.sources.insert(file, text);
    }

    /// The location of a line and a column of a text that was added, both counted from 1.
    pub fn locate(&self, file: &str, line: u32, column: u32) -> Option<Place> {
        self.sources.line(file, line, column)
    }

    /// Puts them in the order of their places and drops what is said twice.
    pub fn sorted(mut self) -> Self {
        let sources = &self.sources;
        self.list.sort_by(|a, b| a.order(sources).cmp(&b.order(sources)).then_with(|| a.message.cmp(&b.message)));
        self.list.dedup();
        self
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// One by one.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
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

impl std::fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.render(Style::Plain))
    }
}

impl std::error::Error for Diagnostics {}

/// A name in backticks, short and without control characters, as messages show what a user wrote.
pub fn quote(name: &str) -> String {
    const LONGEST: usize = 48;
    let shown: String = name.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    // Quotes inside backticks need no escape of their own.
    let shown = shown.replace("\\'", "'").replace("\\\"", "\"");
    if name.chars().nth(LONGEST).is_some() { format!("`{shown}…`") } else { format!("`{shown}`") }
}

/// `a`, `b` and `c` as messages list names; the first `most` of them.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let all: Vec<String> = names.into_iter().map(quote).collect();
    match all.split_last() {
        None => String::new(),
        Some((only, [])) => only.clone(),
        Some((last, rest)) if all.len() <= most => format!("{} and {last}", rest.join(", ")),
        _ => format!("{} and {} more", all[..most].join(", "), all.len() - most),
    }
}

/// "did you mean `x`?" for the nearest of the names that could have been meant.
pub fn did_you_mean<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(wrong, names).map(|name| format!("did you mean {}?", quote(name)))
}

/// The name nearest to `wrong`, if any is near enough to be a slip of the keys: a third of its letters may differ.
pub fn nearest<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LONGEST: usize = 64;
    if wrong.len() > LONGEST {
        return None;
    }
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let meant = plain(wrong);
    let allowed = (wrong.chars().count() / 3).max(1);
    let distance = |name: &str| {
        let plain = plain(name);
        let is_beginning = meant.len() >= 4 && plain.starts_with(&meant);
        if is_beginning { 1 } else { strsim::damerau_levenshtein(&meant, &plain) }
    };
    let near = names.into_iter().filter(|name| name.len() <= LONGEST).map(|name| (distance(name), name));
    near.filter(|(distance, _)| *distance <= allowed).min().map(|(_, name)| name)
}
