//! Syntax errors in words.

use std::sync::Arc;

use ron::Error;

use super::tree::Unreadable;
use crate::diagnostic::{Diagnostic, Place, quote};

/// The error, at its place, with the bracket that is still open where that explains it.
pub(super) fn diagnose(file: &Arc<str>, text: &str, unreadable: &Unreadable) -> Diagnostic {
    let at = start_of(text, unreadable);
    let next = text[at..].chars().next();
    let end = at + next.map_or(0, char::len_utf8);
    let place = Place::new(file, at..end);
    let (message, help) = wording(&unreadable.why, next);
    let diagnostic = Diagnostic::error("syntax", message).at(&place, "").maybe_help(help);
    match scan(text, at) {
        Scan::InText(quote) => {
            let opened = Place::new(file, quote..quote + 1);
            Diagnostic::error("syntax", "a text in quotes does not end")
                .at(&opened, "it begins here")
                .help("close it with `\"` before the end of the line")
        }
        Scan::Open(Some((bracket, open))) if wants_end(&unreadable.why) => {
            let opened = Place::new(file, open..open + 1);
            diagnostic.also(&opened, format!("`{bracket}` is opened here"))
        }
        Scan::Open(_) => diagnostic,
    }
}

/// Where the eye should go: the next sign, not the space before it.
fn start_of(text: &str, unreadable: &Unreadable) -> usize {
    let at = unreadable.at.min(text.len());
    if matches!(unreadable.why, Error::UnclosedBlockComment) {
        return text[..at].rfind("/*").unwrap_or(at);
    }
    let rest = &text[at..];
    match rest.trim_start() {
        "" => at,
        sign => at + rest.len() - sign.len(),
    }
}

fn wants_end(why: &Error) -> bool {
    matches!(
        why,
        Error::Eof
            | Error::ExpectedComma
            | Error::ExpectedArrayEnd
            | Error::ExpectedMapEnd
            | Error::ExpectedStructLikeEnd
            | Error::ExpectedOptionEnd
            | Error::ExpectedMapColon
            | Error::ExpectedIdentifier
    )
}

fn found(next: Option<char>) -> String {
    match next {
        None => "the file ends".into(),
        Some(c) => format!("there is {}", quote(&c.to_string())),
    }
}

fn wording(why: &Error, next: Option<char>) -> (String, Option<String>) {
    let found = found(next);
    let expected = |what: &str| format!("expected {what}, but {found}");
    let (message, help) = match why {
        Error::Eof => ("the file ends too early".into(), "a closing bracket or a quote is missing"),
        Error::ExpectedComma => (expected("a comma or a closing bracket"), "separate entries by commas"),
        Error::ExpectedArrayEnd => (expected("`]`"), "separate entries by commas, and close what you open"),
        Error::ExpectedMapEnd => (expected("`}`"), "separate entries by commas, and close what you open"),
        Error::ExpectedStructLikeEnd | Error::ExpectedOptionEnd => {
            (expected("`)`"), "separate fields by commas, and close what you open")
        }
        Error::ExpectedMapColon => (expected("a colon"), "an entry is written `name: value`"),
        Error::ExpectedIdentifier => (
            expected("a name"),
            "a field is written `name: value`, its name without quotes; or a `)` is missing before it",
        ),
        Error::ExpectedString => (expected("a text in quotes"), "keys of a map are written in quotes"),
        Error::ExpectedStringEnd => ("a text in quotes does not end".into(), "close it with `\"`"),
        Error::UnclosedBlockComment => ("a comment does not end".into(), "close it with `*/`"),
        Error::TrailingCharacters => (
            format!("after the end of the pipeline, {found}"),
            "a file holds one `Pipeline( ... )` and nothing after it",
        ),
        Error::ExceededRecursionLimit => {
            ("brackets are nested too deeply".into(), "a pipeline needs about five levels of brackets")
        }
        Error::InvalidEscape(_) => {
            (format!("a text holds an escape that RON does not know: {found}"), "write a backslash as `\\\\`")
        }
        Error::UnexpectedChar(c) => (format!("{} does not belong here", quote(&c.to_string())), ""),
        other => (lower(&other.to_string()), ""),
    };
    (message, (!help.is_empty()).then(|| help.to_owned()))
}

/// `ron`'s wording as ours: lower case, no full stop.
fn lower(message: &str) -> String {
    let mut chars = message.trim_end_matches('.').chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}

/// What surrounds a byte.
enum Scan {
    /// A text whose quote is there and that runs to the end of the file.
    InText(usize),
    /// The innermost bracket that is open there.
    Open(Option<(char, usize)>),
}

/// Follows brackets, texts and comments up to `at`.
fn scan(text: &str, at: usize) -> Scan {
    let mut open: Vec<(char, usize)> = Vec::new();
    let mut position = 0;
    while let Some(c) = text[position..].chars().next().filter(|_| position < at) {
        let rest = &text[position..];
        match c {
            '(' | '[' | '{' => open.push((c, position)),
            ')' | ']' | '}' => drop(open.pop()),
            '"' => match text_length(rest) {
                Some(length) => {
                    position += length;
                    continue;
                }
                None => return Scan::InText(position),
            },
            '/' if rest.starts_with("//") => {
                position += rest.find('\n').unwrap_or(rest.len());
                continue;
            }
            '/' if rest.starts_with("/*") => {
                position += rest.find("*/").map_or(rest.len(), |end| end + 2);
                continue;
            }
            _ => {}
        }
        position += c.len_utf8();
    }
    Scan::Open(open.pop())
}

/// The length of the quoted text that `rest` begins with, with its quotes.
fn text_length(rest: &str) -> Option<usize> {
    let mut is_escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return Some(at + 1),
            _ => {}
        }
    }
    None
}
