//! Locations in files.

use std::ops::Range;
use std::sync::Arc;

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
