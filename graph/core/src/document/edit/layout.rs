//! The layout of a text: where entries are added between its brackets.

use std::ops::Range;
use std::sync::Arc;

use super::entry::{Entry, Lines, inline, on_lines};
use crate::document::bracket::Bracket;
use crate::document::token::{Kind, Lexer, Token};

/// A text in place of a part of another one.
#[derive(Clone, Debug)]
pub(super) struct Edit {
    pub(super) span: Range<usize>,
    pub(super) text: String,
}

impl Edit {
    fn insert(at: usize, text: impl Into<String>) -> Self {
        Self { span: at..at, text: text.into() }
    }
}

/// A text and its tokens.
pub(super) struct Layout<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    /// What a level of brackets adds to the indentation.
    unit: &'a str,
    /// The end of a line.
    line_end: &'static str,
    /// Whether the sections of the pipeline have lines of their own.
    is_on_lines: bool,
}

/// The indentation of texts that show none.
const UNIT: &str = "    ";

impl<'a> Layout<'a> {
    /// Of a pipeline that begins at that byte.
    pub(super) fn new(file: &Arc<str>, text: &'a str, pipeline: usize) -> Self {
        let mut lexer = Lexer::new(file, text);
        let tokens = std::iter::repeat_with(|| lexer.next()).take_while(|token| token.kind != Kind::End).collect();
        let mut layout = Self { text, tokens, unit: UNIT, line_end: "\n", is_on_lines: false };
        let Some((open, close)) = layout.brackets(pipeline) else { return layout };
        let close = layout.tokens[close];
        layout.is_on_lines = layout.begins_line(&close);
        layout.line_end = layout.end_before(close.line);
        let inner = layout.indent(&layout.tokens[open + 1]);
        let unit = inner.strip_prefix(layout.indent(&close)).filter(|unit| !unit.is_empty());
        layout.unit = unit.filter(|_| layout.is_on_lines).unwrap_or(UNIT);
        layout
    }

    /// The tokens of the brackets of what begins at a byte: they are there, or after one name.
    fn brackets(&self, start: usize) -> Option<(usize, usize)> {
        let first = self.tokens.partition_point(|token| token.start < start);
        let is_open = |index: &usize| matches!(self.tokens.get(*index).map(|t| t.kind), Some(Kind::Open(_)));
        let open = [first, first + 1].into_iter().find(is_open)?;
        let mut depth = 0_usize;
        let close = self.tokens[open..].iter().position(|token| {
            match token.kind {
                Kind::Open(_) => depth += 1,
                Kind::Close(_) => depth -= 1,
                _ => {}
            }
            depth == 0
        });
        Some((open, open + close?))
    }

    /// Where the numbers of a vector are written.
    pub(super) fn numbers(&self, span: &Range<usize>) -> Vec<Range<usize>> {
        let first = self.tokens.partition_point(|token| token.start < span.start);
        let inside = self.tokens[first..].iter().take_while(|token| token.end <= span.end);
        inside.filter(|token| token.kind == Kind::Number).map(|token| token.start..token.end).collect()
    }

    /// Whether there is only space before the token on its line, so that lines can be inserted before it.
    fn begins_line(&self, token: &Token) -> bool {
        token.line > 0 && self.text[token.line..token.start].trim().is_empty()
    }

    /// The space that the token's line begins with.
    fn indent(&self, token: &Token) -> &'a str {
        let line = &self.text[token.line..token.start];
        &line[..line.find(|c| c != ' ' && c != '\t').unwrap_or(line.len())]
    }

    /// How the line before that byte ends.
    fn end_before(&self, line: usize) -> &'static str {
        if self.text[..line].ends_with("\r\n") { "\r\n" } else { "\n" }
    }

    /// Adds entries between the brackets of what begins at a byte.
    pub(super) fn insert(&self, start: usize, entries: &[Entry]) -> Vec<Edit> {
        if entries.is_empty() {
            return Vec::new();
        }
        let Some((open, close)) = self.brackets(start) else { return self.parenthesize(start, entries) };
        if self.begins_line(&self.tokens[close]) {
            return self.insert_lines(open, close, entries);
        }
        if open + 1 == close {
            return vec![self.fill(&self.tokens[open], &self.tokens[close], entries)];
        }
        let is_comma = self.tokens[close - 1].kind == Kind::Comma;
        let last = &self.tokens[close - 1 - usize::from(is_comma)];
        vec![Edit::insert(last.end, format!(", {}", inline(entries)))]
    }

    /// Entries behind a kind without parentheses.
    fn parenthesize(&self, start: usize, entries: &[Entry]) -> Vec<Edit> {
        let name = self.tokens.iter().find(|token| token.start == start);
        name.map(|name| Edit::insert(name.end, format!("({})", inline(entries)))).into_iter().collect()
    }

    /// Lines before that of the closing bracket; a comma follows the last one if it followed the last entry.
    fn insert_lines(&self, open: usize, close: usize, entries: &[Entry]) -> Vec<Edit> {
        let is_empty = open + 1 == close;
        let [open, first, last, close] = [open, open + 1, close - 1, close].map(|index| self.tokens[index]);
        let outer = self.indent(&close);
        let has_own_line = first.line > open.line && !is_empty;
        let indent = if has_own_line { self.indent(&first).to_owned() } else { format!("{outer}{}", self.unit) };
        let end = self.end_before(close.line);
        let lines = on_lines(entries, &indent, Lines { unit: self.unit, end });
        let has_comma = is_empty || last.kind == Kind::Comma;
        let comma = if has_comma { "," } else { "" };
        let missing = (!has_comma).then(|| Edit::insert(last.end, ","));
        missing.into_iter().chain([Edit::insert(close.line, format!("{lines}{comma}{end}"))]).collect()
    }

    /// Entries between brackets without any.
    fn fill(&self, open: &Token, close: &Token, entries: &[Entry]) -> Edit {
        let has_gap = open.end < close.start;
        let text = match open.kind {
            Kind::Open(Bracket::Curly) if self.is_on_lines && !has_gap => {
                let (outer, end) = (self.indent(open), self.line_end);
                let lines = on_lines(entries, &format!("{outer}{}", self.unit), Lines { unit: self.unit, end });
                format!("{end}{lines},{end}{outer}")
            }
            Kind::Open(Bracket::Curly) if has_gap => format!(" {}", inline(entries)),
            Kind::Open(Bracket::Curly) => format!(" {} ", inline(entries)),
            _ => inline(entries),
        };
        Edit::insert(open.end, text)
    }

    /// The text with edits, none of which touches a part of another one.
    pub(super) fn edited(&self, mut edits: Vec<Edit>) -> String {
        edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
        let mut edited = String::with_capacity(self.text.len());
        let mut at = 0;
        for Edit { span, text } in edits {
            edited += &self.text[at..span.start];
            edited += &text;
            at = span.end;
        }
        edited + &self.text[at..]
    }
}
