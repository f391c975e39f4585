//! Syntax errors in words.

use std::sync::Arc;

use ron::Error;

use super::tree::{Unreadable, is_space};
use afterimage_base::diagnostic::{Diagnostic, Place, quote};

/// The error, at its place, with the bracket that is still open where that explains it.
pub(super) fn diagnose(file: &Arc<str>, text: &str, unreadable: &Unreadable) -> Diagnostic {
    let at = start_of(text, unreadable);
    let next = text[at..].chars().next();
    let end = at + next.map_or(0, char::len_utf8);
    let place = Place::new(file, at..end);
    let surroundings = scan(text, at);
    let (message, help) = habit(text, at)
        .or_else(|| wrong_bracket(&surroundings, next))
        .unwrap_or_else(|| wording(&unreadable.why, next));
    let diagnostic = Diagnostic::error("syntax", message).at(&place, "").maybe_help(help);
    match surroundings {
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
    let begun_by = match unreadable.why {
        Error::UnclosedBlockComment => Some("/*"),
        Error::ExpectedAttribute => Some("#"),
        _ => None,
    };
    if let Some(begun) = begun_by {
        return text[..at].rfind(begun).unwrap_or(at);
    }
    let rest = &text[at..];
    match rest.trim_start_matches(is_space) {
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

/// What people write out of the habit of other languages, or of an editor: message and help.
fn habit(text: &str, at: usize) -> Option<(String, Option<String>)> {
    let (before, rest) = text.split_at(at);
    let next = rest.chars().next()?;
    let said = |message: String, help: &str| Some((message, Some(help.to_owned())));
    match next {
        '\u{201c}' | '\u{201d}' | '\u{201e}' | '\u{2018}' | '\u{2019}' | '\u{ab}' | '\u{bb}' | '\'' => said(
            format!("{} is no quote of RON", quote(&next.to_string())),
            "write a plain `\"` before and after a text",
        ),
        '\u{200b}'..='\u{200d}' | '\u{feff}' => {
            let message = format!("an invisible character, U+{:04X}, does not belong here", next as u32);
            said(message, "delete it")
        }
        c if c.is_whitespace() && !is_space(c) => {
            let message = format!("the space U+{:04X} does not belong here", c as u32);
            said(message, "put a plain space in its place")
        }
        '/' if before.ends_with(|c: char| c.is_ascii_digit()) => {
            said("a number cannot be written as a division".into(), "write what it comes to, such as `0.5`")
        }
        c if c.is_ascii_digit()
            && before.ends_with(',')
            && before[..at - 1].ends_with(|c: char| c.is_ascii_digit()) =>
        {
            said("a decimal number has a point and no comma".into(), "write it as `0.5`")
        }
        _ => number_with_unit(text, at),
    }
}

/// `0.5ev` or `10px`, at its number or at its unit.
fn number_with_unit(text: &str, at: usize) -> Option<(String, Option<String>)> {
    let is_inner = |c: char| c.is_alphanumeric() || matches!(c, '.' | '_' | '+' | '-' | '%');
    let start = text[..at].rfind(|c| !is_inner(c)).map_or(0, |before| before + 1);
    let start = (start..=at).find(|start| text.is_char_boundary(*start))?;
    let word: String = text[start..].chars().take_while(|c| is_inner(*c)).collect();
    let digits = word.trim_start_matches(['-', '+', '.']);
    let is_number = digits.starts_with(|c: char| c.is_ascii_digit());
    let has_unit = digits.contains(|c: char| c.is_alphabetic() || c == '%');
    let message = format!("{} is not a number", quote(&word));
    (is_number && has_unit).then(|| (message, Some("numbers stand without a unit".to_owned())))
}

/// A bracket that is closed by another one, and names where a list has none.
fn wrong_bracket(surroundings: &Scan, next: Option<char>) -> Option<(String, Option<String>)> {
    let Scan::Open(Some((open, _))) = surroundings else { return None };
    let close = match open {
        '(' => ')',
        '[' => ']',
        _ => '}',
    };
    match next? {
        next @ (')' | ']' | '}') if next != close => Some((
            format!("`{open}` is closed by `{next}`"),
            Some(format!("write `{close}` before it, or take the `{next}` away")),
        )),
        ':' if *open == '[' => {
            Some(("a list in `[ ]` has no names".into(), Some("entries with names stand in `{ }`".into())))
        }
        _ => None,
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
        Error::ExpectedAttribute => ("`#` begins no comment".into(), "comments begin with `//`"),
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
