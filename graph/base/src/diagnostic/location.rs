//! Locations in files, and the texts of the files.

use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

/// A range of bytes of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// The file's name.
    pub file: Arc<str>,
    /// From the first byte.
    pub start: usize,
    /// To the byte after the last.
    pub end: usize,
}

impl Location {
    /// The bytes `span` of `file`.
    pub fn new(file: &Arc<str>, span: Range<usize>) -> Self {
        Self { file: file.clone(), start: span.start, end: span.end.max(span.start) }
    }

    /// The bytes as a range.
    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }

    /// A part of this location, counted from its first byte.
    pub fn part(&self, span: Range<usize>) -> Self {
        Self::new(&self.file, self.start + span.start..self.start + span.end)
    }
}

/// A value and its location.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// The location.
    pub location: Location,
}

impl<T> Spanned<T> {
    /// A value at a location.
    pub fn new(value: T, location: Location) -> Self {
        Self { value, location }
    }
}

/// The texts of files by name, in the order of insertion.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: IndexMap<Arc<str>, Arc<str>>,
}

/// A line and a column, both counted from 1; the column in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The character in the line.
    pub column: usize,
}

impl Sources {
    /// Adds a file; a file that is there already keeps its text. Returns the name that locations hold.
    pub fn insert(&mut self, file: &str, text: &str) -> Arc<str> {
        if let Some((name, _)) = self.texts.get_key_value(file) {
            return name.clone();
        }
        let name: Arc<str> = file.into();
        self.texts.insert(name.clone(), text.into());
        name
    }

    /// The text of a file.
    pub fn text(&self, file: &str) -> Option<&str> {
        self.texts.get(file).map(|text| &**text)
    }

    pub(super) fn absorb(&mut self, other: Self) {
        for (file, text) in other.texts {
            self.texts.entry(file).or_insert(text);
        }
    }

    /// The position of a file in the order of insertion; after all of them if it is unknown.
    pub(super) fn rank(&self, file: &str) -> usize {
        self.texts.get_index_of(file).unwrap_or(self.texts.len())
    }

    /// Line and column of a byte of a file; the end of the text for bytes after it.
    pub fn position(&self, file: &str, byte: usize) -> Option<Position> {
        let text = self.text(file)?;
        let before = &text[..floor(text, byte)];
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = before.bytes().filter(|b| *b == b'\n').count() + 1;
        Some(Position { line, column: before[start..].chars().count() + 1 })
    }

    /// The location of the word or sign at a line and a column, both counted from 1; column 0 is the first letter.
    pub fn line(&self, file: &str, line: u32, column: u32) -> Option<Location> {
        let (name, text) = self.texts.get_key_value(file)?;
        let start: usize = text.split_inclusive('\n').take((line as usize).checked_sub(1)?).map(str::len).sum();
        let content = text.get(start..)?.lines().next()?;
        let indent = content.len() - content.trim_start().len();
        // naga counts columns in bytes.
        let from = if column == 0 { indent } else { floor(content, column as usize - 1) };
        let word = content[from..].find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(content.len() - from);
        let sign = content[from..].chars().next().map_or(0, char::len_utf8);
        Some(Location::new(name, start + from..start + from + word.max(sign)))
    }
}

/// The last character boundary at or before a byte.
pub(super) fn floor(text: &str, byte: usize) -> usize {
    let mut at = byte.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}
