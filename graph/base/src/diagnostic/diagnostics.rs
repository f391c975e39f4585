//! One diagnostic, the list of all diagnostics with the texts that they point into, and both as text: the excerpts with
//! underlined locations, and the hints.

use std::borrow::Cow;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet};
use serde::Serialize;

use super::location::{Location, Sources, floor};
use super::names::{equally_near, is_control, quote, shown};

/// Severity of a diagnostic.
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
    /// Text at the location; may be empty.
    pub text: String,
    /// True if this is the location of the error, not one that explains it.
    pub primary: bool,
}

/// An error or a warning. Its texts are of one line each: what they quote of files has escapes for control characters.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// A stable name in kebab case.
    pub code: &'static str,
    /// The severity.
    pub severity: Severity,
    /// The message: lower case, no full stop.
    pub message: String,
    /// The locations, the primary one first.
    pub labels: Vec<Label>,
    /// A hint: what to do about it.
    pub help: Option<String>,
    /// A fix, if one is known.
    pub correction: Option<Box<Correction>>,
}

/// Words of a file, and what to write in their place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Correction {
    /// The words in the primary location that are wrong; empty if the whole location is.
    pub wrong: String,
    /// The right ones.
    pub right: String,
}

impl Diagnostic {
    fn new(code: &'static str, severity: Severity, message: impl Into<String>) -> Self {
        let message = one_line(message);
        Self { code, severity, message, labels: Vec::new(), help: None, correction: None }
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
        self.labels.push(Label { location: location.clone(), text: one_line(text), primary: true });
        self
    }

    /// Adds a location that explains the error.
    pub fn also(mut self, location: &Location, text: impl Into<String>) -> Self {
        self.labels.push(Label { location: location.clone(), text: one_line(text), primary: false });
        self
    }

    /// Sets the hint.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(one_line(text));
        self
    }

    /// Sets the hint if there is one; otherwise the present one stays.
    pub fn maybe_help(mut self, text: Option<String>) -> Self {
        self.help = text.map(one_line).or(self.help);
        self
    }

    /// Sets the hint to the name that `wrong` is nearest to, if it is near to any. If no other name is as near, it also
    /// becomes the [correction](Diagnostic::correction).
    pub fn did_you_mean<'a>(mut self, wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let near = equally_near(wrong, names);
        let Some(first) = near.first() else { return self };
        let names: Vec<String> = near.iter().take(3).map(|name| quote(name)).collect();
        self.help = Some(format!("did you mean {}?", names.join(" or ")));
        // In a text in quotes, some characters would need an escape.
        let is_plain = !first.contains(['"', '\\']) && !first.contains(is_control);
        if near.len() == 1 && is_plain { self.correct(wrong, *first) } else { self }
    }

    /// Sets what to write in the place of `wrong`.
    pub fn correct(mut self, wrong: impl Into<String>, right: impl Into<String>) -> Self {
        self.correction = Some(Box::new(Correction { wrong: wrong.into(), right: right.into() }));
        self
    }

    /// Sets what to write in the place of the whole primary location.
    pub fn rewrite(self, right: impl Into<String>) -> Self {
        self.correct("", right)
    }

    fn order(&self, sources: &Sources) -> (usize, usize, Severity, &'static str) {
        match self.labels.first() {
            Some(label) => (sources.rank(&label.location.file), label.location.start, self.severity, self.code),
            None => (0, 0, self.severity, self.code),
        }
    }
}

/// All diagnostics, with the texts that their locations point into.
#[derive(Clone, Default)]
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

    /// Returns whether any is an error.
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

    /// Returns whether there are no diagnostics.
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

/// Options for rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Text only.
    #[default]
    Plain,
    /// With the colors of a terminal.
    Colored,
}

/// The number of diagnostics that are shown; more are only counted.
const MAX_SHOWN: usize = 50;
/// A longer line, in bytes, is not shown; the message names its location.
const MAX_LINE: usize = 2000;
/// Locations of one file that lie further apart, in bytes, get excerpts of their own.
const MAX_EXCERPT: usize = 1 << 16;

impl Diagnostics {
    /// All errors and warnings as text, each with its excerpt. Beyond a limit only their number is given.
    pub fn render(&self, style: Style) -> String {
        let renderer = match style {
            Style::Plain => Renderer::plain(),
            Style::Colored => Renderer::styled(),
        };
        let mut parts: Vec<String> = self.iter().take(MAX_SHOWN).map(|d| one(d, &self.sources, &renderer)).collect();
        if self.len() > MAX_SHOWN {
            parts.push(format!("and {} more like these", self.len() - MAX_SHOWN));
        }
        parts.iter().map(|part| part.trim_end().to_owned() + "\n").collect::<Vec<_>>().join("\n")
    }
}

impl std::fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.render(Style::Plain))
    }
}

/// As for people, because `main` prints the errors that it returns in this way.
impl std::fmt::Debug for Diagnostics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "\n{self}")
    }
}

impl std::error::Error for Diagnostics {}

fn one(diagnostic: &Diagnostic, sources: &Sources, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(shown(&diagnostic.message)).id(diagnostic.code);
    let mut group = Group::with_title(title).elements(excerpts(&diagnostic.labels, sources));
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(shown(help)));
    }
    renderer.render(&[group])
}

fn one_line(text: impl Into<String>) -> String {
    shown(&text.into()).into_owned()
}

/// The text of an excerpt without the control characters that the renderer does not replace: those from U+0080.
/// Each becomes a character of as many bytes, so that locations stay.
fn pictured(text: &str) -> Cow<'_, str> {
    if !text.contains(is_left) {
        return text.into();
    }
    let pictures = |c: char| match c.len_utf8() {
        _ if !is_left(c) => c,
        2 => '·',
        _ => '\u{fffd}',
    };
    text.chars().map(pictures).collect::<String>().into()
}

fn is_left(c: char) -> bool {
    !c.is_ascii() && is_control(c)
}

/// One excerpt per file, in the order in which the labels name the files.
fn excerpts<'a>(labels: &'a [Label], sources: &'a Sources) -> Vec<Element<'a>> {
    let mut files: Vec<&str> = Vec::new();
    for label in labels {
        if !files.contains(&&*label.location.file) {
            files.push(&label.location.file);
        }
    }
    let of = |file: &str| labels.iter().filter(|l| *l.location.file == *file).collect::<Vec<_>>();
    files.into_iter().flat_map(|file| excerpt(file, &of(file), sources)).collect()
}

fn excerpt<'a>(file: &'a str, labels: &[&'a Label], sources: &'a Sources) -> Vec<Element<'a>> {
    let Some(text) = sources.text(file) else { return vec![Origin::path(shown(file)).into()] };
    let whole = window(text, labels.iter().map(|l| l.location.span()));
    if whole.len() <= MAX_EXCERPT && shows(&text[whole.clone()]) {
        return vec![snippet(file, text, whole, labels)];
    }
    labels.iter().map(|label| alone(file, text, label, sources)).collect()
}

/// A label without the others: the excerpt around it, or only its position when even its lines are too long.
fn alone<'a>(file: &'a str, text: &'a str, label: &'a Label, sources: &Sources) -> Element<'a> {
    let lines = window(text, [label.location.span()]);
    if lines.len() <= MAX_EXCERPT && shows(&text[lines.clone()]) {
        return snippet(file, text, lines, &[label]);
    }
    let origin = Origin::path(shown(file));
    match sources.position(file, label.location.start) {
        Some(at) => origin.line(at.line).char_column(at.column).into(),
        None => origin.into(),
    }
}

fn shows(text: &str) -> bool {
    text.lines().all(|line| line.len() <= MAX_LINE)
}

/// The whole lines that hold all of the spans.
fn window(text: &str, spans: impl IntoIterator<Item = Range<usize>>) -> Range<usize> {
    let (mut low, mut high) = (text.len(), 0);
    for span in spans {
        low = low.min(span.start);
        high = high.max(span.end);
    }
    let (low, high) = (floor(text, low), floor(text, high.max(low)));
    let start = text[..low].rfind('\n').map_or(0, |at| at + 1);
    start..text[high..].find('\n').map_or(text.len(), |at| high + at)
}

fn snippet<'a>(file: &'a str, text: &'a str, lines: Range<usize>, labels: &[&'a Label]) -> Element<'a> {
    let first = text[..lines.start].bytes().filter(|b| *b == b'\n').count() + 1;
    let annotations = labels.iter().map(|label| {
        let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
        let start = floor(text, label.location.start).clamp(lines.start, lines.end) - lines.start;
        let end = floor(text, label.location.end).clamp(lines.start, lines.end) - lines.start;
        let annotation = kind.span(start..end.max(start));
        if label.text.is_empty() { annotation } else { annotation.label(shown(&label.text)) }
    });
    Snippet::source(pictured(&text[lines.clone()])).path(shown(file)).line_start(first).annotations(annotations).into()
}
