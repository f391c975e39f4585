//! Map from the bytes of a linked module to those of its files.

use afterimage_base::Shared;

use crate::error::{Place, ShaderError, position};

/// The name of the file that generated text belongs to.
pub(crate) const GENERATED: &str = "(generated)";

/// Bytes of the module that come from successive bytes of a file.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// The first byte in the module.
    at: u32,
    file: u32,
    /// The first byte in the file.
    source: u32,
    /// Bytes in the file. Where the module has more, all others came from the last.
    length: u32,
}

#[derive(Clone, Debug)]
struct MappedFile {
    name: Shared<str>,
    text: Shared<str>,
    /// True if it is one of the framework's library.
    is_framework: bool,
}

/// Map from the bytes of a linked module to those of its files.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    files: Vec<MappedFile>,
    segments: Vec<Segment>,
}

impl SourceMap {
    pub(super) fn file(&mut self, name: &Shared<str>, text: &Shared<str>, is_framework: bool) {
        self.files.push(MappedFile { name: name.clone(), text: text.clone(), is_framework });
    }

    /// The bytes of the module from `at` on come from `length` bytes of the last file, from `source` on.
    pub(super) fn segment(&mut self, at: usize, source: usize, length: usize) {
        let file = self.files.len() as u32 - 1;
        self.segments.push(Segment { at: at as u32, file, source: source as u32, length: length as u32 });
    }

    /// An error at a byte of the module, if its byte is known and came from a file.
    pub(crate) fn error(&self, byte: Option<usize>, message: String) -> ShaderError {
        match byte.and_then(|byte| self.locate(byte)) {
            Some(place) => ShaderError::new(&place.file, (place.line, place.column), message),
            None => ShaderError::new(GENERATED, (0, 0), message),
        }
    }

    /// Source of a byte of the module; `None` for text before the first declaration.
    pub fn locate(&self, byte: usize) -> Option<Place> {
        let segment = self.segment_of(byte)?;
        let MappedFile { name, text, .. } = &self.files[segment.file as usize];
        let away = (byte - segment.at as usize).min((segment.length as usize).saturating_sub(1));
        let (line, column) = position(text, segment.source as usize + away);
        Some(Place { file: name.to_string(), line, column })
    }

    /// The texts of the files that are not of the framework.
    pub(crate) fn author_texts(&self) -> impl Iterator<Item = &str> {
        self.files.iter().filter(|file| !file.is_framework).map(|file| &*file.text)
    }

    fn segment_of(&self, byte: usize) -> Option<&Segment> {
        let after = self.segments.partition_point(|segment| segment.at as usize <= byte);
        self.segments.get(after.checked_sub(1)?)
    }

    /// Of the places that a parser's error names, the first in a file of an author. If there is none, a declaration of
    /// the author has no end, and the parser went on behind it: the last place of an author before.
    pub(crate) fn of_author(&self, bytes: impl IntoIterator<Item = usize>) -> Option<usize> {
        let is_authors = |segment: &Segment| !self.files[segment.file as usize].is_framework;
        let bytes: Vec<usize> = bytes.into_iter().collect();
        let named = bytes.iter().copied().find(|byte| self.segment_of(*byte).is_some_and(is_authors));
        named.or_else(|| {
            let first = *bytes.first()?;
            let after = self.segments.partition_point(|segment| segment.at as usize <= first);
            let last = self.segments[..after].iter().rposition(is_authors);
            Some(last.map_or(first, |last| self.segments[last + 1].at as usize - 1))
        })
    }
}
