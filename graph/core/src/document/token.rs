//! RON text as tokens.
//!
//! The lexer skips space and comments. It reports what cannot be a token and continues after it: a text that is not
//! closed ends on its line, so that the next line is read as it is meant.

use std::sync::Arc;

use super::bracket::Bracket;
use super::quotes::{character_end, foreign_end, is_foreign_quote, plain_end, raw_end, text_end};
use super::syntax::{self, Errors};
use afterimage_base::diagnostic::Location;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A name, raw or not.
    Word,
    /// A number, or what looks like one.
    Number,
    /// A string in plain quotes or a raw string.
    Text,
    /// A string in quotes that RON does not know, which have been reported.
    ForeignText,
    /// A string that is not closed, which has been reported.
    BrokenText,
    Literal,
    Open(Bracket),
    Close(Bracket),
    Comma,
    Colon,
    /// A character that RON does not use.
    Stray,
    End,
}

/// A token, its bytes, and where it stands on its line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token {
    pub(super) kind: Kind,
    pub(super) start: usize,
    pub(super) end: usize,
    /// First byte of its line.
    pub(super) line: usize,
    /// Bytes before the first token of its line.
    pub(super) indent: usize,
}

impl Token {
    /// Returns whether it is the first of its line.
    pub(super) fn is_first_on_line(&self) -> bool {
        self.start == self.line + self.indent
    }

    /// Returns whether a value can begin with it.
    pub(super) fn begins_value(&self) -> bool {
        !matches!(self.kind, Kind::Close(_) | Kind::Comma | Kind::Colon | Kind::Stray | Kind::End)
    }
}

/// Returns whether RON treats the character as space.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}')
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Reads tokens one after the other.
pub(super) struct Lexer<'a> {
    file: &'a Arc<str>,
    pub(super) text: &'a str,
    at: usize,
    line: usize,
    indent: Option<usize>,
    has_begun: bool,
    pub(super) errors: Errors,
    /// True if a comment runs to the end of the file, so that what is missing there may be in it.
    pub(super) ends_in_comment: bool,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(file: &'a Arc<str>, text: &'a str) -> Self {
        let errors = Errors::default();
        Self { file, text, at: 0, line: 0, indent: None, has_begun: false, errors, ends_in_comment: false }
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    pub(super) fn location(&self, start: usize, end: usize) -> Location {
        Location::new(self.file, start..end)
    }

    /// The next token; [`Kind::End`] again and again at the end, or once there are too many errors.
    pub(super) fn next(&mut self) -> Token {
        self.skip_space();
        self.has_begun = true;
        let start = self.at;
        let (line, indent) = (self.line, *self.indent.get_or_insert(start - self.line));
        let (kind, end) = self.token();
        self.go_to(if self.errors.is_full() { self.text.len() } else { end });
        Token { kind, start, end, line, indent }
    }

    /// Moves on and counts lines.
    fn go_to(&mut self, end: usize) {
        if let Some(newline) = self.text[self.at..end].rfind('\n') {
            self.line = self.at + newline + 1;
            self.indent = None;
        }
        self.at = end;
    }

    fn skip_space(&mut self) {
        while let Some(c) = self.rest().chars().next() {
            let rest = self.rest();
            let end = match c {
                c if is_space(c) => self.at + rest.find(|c| !is_space(c)).unwrap_or(rest.len()),
                '/' if rest.starts_with("//") => self.line_end(),
                '/' if rest.starts_with("/*") => self.comment_end(),
                '#' => self.hash_end(),
                '\u{200b}'..='\u{200d}' | '\u{feff}' => self.foreign_space(c, syntax::invisible),
                c if c.is_whitespace() => self.foreign_space(c, syntax::foreign_space),
                _ => return,
            };
            self.go_to(if self.errors.is_full() { self.text.len() } else { end });
        }
    }

    fn line_end(&self) -> usize {
        self.rest().find('\n').map_or(self.text.len(), |at| self.at + at)
    }

    fn foreign_space(
        &mut self,
        c: char,
        report: fn(&Location, char) -> afterimage_base::diagnostic::Diagnostic,
    ) -> usize {
        let end = self.rest().find(|other| other != c).map_or(self.text.len(), |length| self.at + length);
        self.errors.push(report(&self.location(self.at, end), c));
        end
    }

    /// The end of a comment in `/* */`; such comments nest.
    fn comment_end(&mut self) -> usize {
        let rest = self.rest();
        let (mut depth, mut at) = (0_usize, 0);
        while let Some(found) = rest[at..].find(['/', '*']) {
            at += found;
            let step = match rest.get(at..at + 2) {
                Some("/*") => (depth + 1, 2),
                Some("*/") => (depth - 1, 2),
                _ => (depth, 1),
            };
            (depth, at) = (step.0, at + step.1);
            if depth == 0 {
                return self.at + at;
            }
        }
        self.ends_in_comment = true;
        self.errors.push(syntax::open_comment(&self.location(self.at, self.at + 2)));
        self.text.len()
    }

    /// The end of `#![enable(...)]`, which a file may begin with, or of what is meant as a comment.
    fn hash_end(&mut self) -> usize {
        const MAX_LENGTH: usize = 256;
        let rest = self.rest();
        let attribute = rest.bytes().take(MAX_LENGTH).position(|byte| byte == b']').map(|end| &rest[..=end]);
        match attribute.filter(|_| !self.has_begun) {
            Some(attribute) if ron::de::Deserializer::from_str(attribute).is_ok() => self.at + attribute.len(),
            _ => {
                self.errors.push(syntax::hash(&self.location(self.at, self.at + 1)));
                self.line_end()
            }
        }
    }

    /// The kind and the end of the token here.
    fn token(&mut self) -> (Kind, usize) {
        let rest = self.rest();
        let Some(c) = rest.chars().next() else { return (Kind::End, self.at) };
        let one = self.at + c.len_utf8();
        if let Some(kind) = sign(c) {
            return (kind, one);
        }
        match c {
            '"' => self.plain_text(),
            'r' | 'b' => self.raw_or_bytes().unwrap_or_else(|| (Kind::Word, self.word_end())),
            c if is_foreign_quote(c) => self.foreign_text(c),
            c if c.is_alphabetic() || c == '_' => (Kind::Word, self.word_end()),
            c if c.is_ascii_digit() || begins_number(rest) => (Kind::Number, self.number_end()),
            c if c.is_ascii() => (Kind::Stray, self.at + rest.find(|other| other != c).unwrap_or(rest.len())),
            _ => (Kind::Stray, one),
        }
    }

    fn word_end(&self) -> usize {
        let (skipped, is_raw) = if self.rest().starts_with("r#") { (2, true) } else { (0, false) };
        let is_end = |c: char| !(is_word(c) || is_raw && ".+-".contains(c));
        self.rest()[skipped..].find(is_end).map_or(self.text.len(), |end| self.at + skipped + end)
    }

    /// The end of a number with all that is written without a space, so that `0.5ev` is one token.
    fn number_end(&self) -> usize {
        let is_end = |c: char| !(is_word(c) || ".+-%".contains(c));
        self.rest().find(is_end).map_or(self.text.len(), |end| self.at + end)
    }

    fn plain_text(&mut self) -> (Kind, usize) {
        match plain_end(self.text, self.at) {
            Ok(end) => (Kind::Text, end),
            Err(end) => {
                self.errors.push(syntax::open_text(&self.location(self.at, self.at + 1)));
                (Kind::BrokenText, end)
            }
        }
    }

    /// `r"..."`, `r#"..."#`, `b"..."`, `br"..."` or `b'...'`, if that is what is here.
    fn raw_or_bytes(&mut self) -> Option<(Kind, usize)> {
        let rest = self.rest();
        let (kind, quote) = rest.strip_prefix('b').map_or((Kind::Text, rest), |quote| (Kind::Literal, quote));
        let start = self.at + rest.len() - quote.len();
        let hashes = quote.bytes().skip(1).take_while(|byte| *byte == b'#').count();
        let end = match quote.as_bytes().first()? {
            b'\'' => character_end(self.text, start),
            b'"' => text_end(self.text, start),
            b'r' if quote.as_bytes().get(1 + hashes) == Some(&b'"') => raw_end(self.text, start + 1, hashes),
            _ => return None,
        };
        if end.is_none() {
            self.errors.push(syntax::open_text(&self.location(self.at, self.at + 1)));
        }
        Some(end.map_or_else(|| (Kind::BrokenText, self.line_end()), |end| (kind, end)))
    }

    /// A text in quotes of a word processor or in single quotes; `'x'` is a character of RON.
    fn foreign_text(&mut self, quote: char) -> (Kind, usize) {
        let is_character = |end: &usize| ron::from_str::<char>(&self.text[self.at..*end]).is_ok();
        let character = if quote == '\'' { character_end(self.text, self.at) } else { None };
        if let Some(end) = character.filter(is_character) {
            return (Kind::Literal, end);
        }
        let end = foreign_end(self.text, self.at);
        let one = self.at + quote.len_utf8();
        self.errors.push(syntax::foreign_quote(&self.location(self.at, one), quote));
        end.map_or((Kind::BrokenText, one), |end| (Kind::ForeignText, end))
    }
}

/// A token of one character.
fn sign(c: char) -> Option<Kind> {
    Some(match c {
        ',' => Kind::Comma,
        ':' => Kind::Colon,
        '(' => Kind::Open(Bracket::Round),
        '[' => Kind::Open(Bracket::Square),
        '{' => Kind::Open(Bracket::Curly),
        ')' => Kind::Close(Bracket::Round),
        ']' => Kind::Close(Bracket::Square),
        '}' => Kind::Close(Bracket::Curly),
        _ => return None,
    })
}

/// Returns whether a sign or a point begins a number.
fn begins_number(rest: &str) -> bool {
    let mut chars = rest.chars();
    match (chars.next(), chars.next()) {
        (Some('+' | '-'), Some(next)) => next.is_ascii_alphanumeric() || next == '.',
        (first, _) => first == Some('.'),
    }
}
