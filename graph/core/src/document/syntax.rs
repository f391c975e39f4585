//! Syntax errors in words, and how many of them are kept.

use super::bracket::Bracket;
use afterimage_base::diagnostic::{Diagnostic, Location, quote};

/// More syntax errors than this are not collected: the text is no RON then.
const MAX_ERRORS: usize = 128;

/// The errors found so far.
#[derive(Default)]
pub(super) struct Errors(Vec<Diagnostic>);

impl Errors {
    pub(super) fn push(&mut self, error: Diagnostic) {
        if !self.is_full() {
            self.0.push(error);
        }
    }

    pub(super) fn is_full(&self) -> bool {
        self.0.len() >= MAX_ERRORS
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn last(&self) -> Option<&Diagnostic> {
        self.0.last()
    }

    pub(super) fn into_list(self) -> Vec<Diagnostic> {
        self.0
    }
}

fn error(message: impl Into<String>, location: &Location, help: impl Into<String>) -> Diagnostic {
    Diagnostic::error("syntax", message).at(location, "").help(help)
}

/// Text for messages: the whole token at a place.
pub(super) fn found(token: &str) -> String {
    if token.is_empty() { "the file ends".into() } else { format!("there is {}", quote(token)) }
}

pub(super) fn open_text(quote: &Location) -> Diagnostic {
    error("a text in quotes does not end", quote, "close it with `\"`")
}

pub(super) fn open_comment(start: &Location) -> Diagnostic {
    error("a comment does not end", start, "close it with `*/`")
}

pub(super) fn hash(location: &Location) -> Diagnostic {
    error("`#` begins no comment", location, "comments begin with `//`")
}

pub(super) fn foreign_quote(location: &Location, c: char) -> Diagnostic {
    let message = format!("{} is not a quotation mark in RON", quote(&c.to_string()));
    error(message, location, "write a plain `\"` before and after a text")
}

pub(super) fn invisible(location: &Location, c: char) -> Diagnostic {
    let message = format!("an invisible character, U+{:04X}, does not belong here", c as u32);
    error(message, location, "delete it")
}

pub(super) fn foreign_space(location: &Location, c: char) -> Diagnostic {
    let message = format!("the space U+{:04X} does not belong here", c as u32);
    error(message, location, "replace it by a plain space")
}

pub(super) fn bad_escape(location: &Location) -> Diagnostic {
    error("a text holds an escape that RON does not know", location, "write a backslash as `\\\\`")
}

pub(super) fn bad_number(location: &Location, word: &str) -> Diagnostic {
    let has_unit = word.contains(|c: char| c.is_alphabetic() || c == '%');
    let help = match word.strip_prefix('.') {
        Some(ending) if ending.starts_with(char::is_alphabetic) => "the name of a file is a text in quotes",
        _ if has_unit => "numbers stand without a unit",
        _ => "write numbers as `10`, `-2.5` or `1e3`",
    };
    error(format!("{} is not a number", quote(word)), location, help)
}

pub(super) fn division(location: &Location) -> Diagnostic {
    error("a number cannot be written as a division", location, "write its value, such as `0.5`")
}

/// `number` is the number with a point.
pub(super) fn decimal_comma(location: &Location, number: &str) -> Diagnostic {
    error("a decimal number has a point and no comma", location, format!("write it as {}", quote(number)))
}

pub(super) fn stray(location: &Location, token: &str) -> Diagnostic {
    Diagnostic::error("syntax", format!("{} does not belong here", quote(token))).at(location, "")
}

pub(super) fn no_value(location: &Location, token: &str) -> Diagnostic {
    let message = format!("expected a value, but {}", found(token));
    error(message, location, "a value is a name, a number, a text in quotes or a group in brackets")
}

pub(super) fn no_entry(location: &Location, token: &str) -> Diagnostic {
    error(format!("expected an entry, but {}", found(token)), location, "one comma separates two entries")
}

pub(super) fn missing_comma(location: &Location, token: &str) -> Diagnostic {
    error(format!("a comma is missing before {}", quote(token)), location, "separate entries by commas")
}

pub(super) fn no_comma(location: &Location, token: &str) -> Diagnostic {
    error(format!("expected a comma, but {}", found(token)), location, "separate entries by commas")
}

pub(super) fn no_colon(location: &Location, token: &str) -> Diagnostic {
    if token.strip_prefix('.').is_some_and(|rest| rest.starts_with(char::is_alphabetic)) {
        return error("a name with a point is a text in quotes", location, "write `\"node.parameter\": value`");
    }
    error(format!("expected a colon, but {}", found(token)), location, "an entry is written `name: value`")
}

pub(super) fn second_colon(location: &Location) -> Diagnostic {
    error("expected a comma or a closing bracket, but there is `:`", location, "an entry is written `name: value`")
}

pub(super) fn no_name(location: &Location, token: &str) -> Diagnostic {
    let message = format!("expected a name, but {}", found(token));
    let in_brackets = token.strip_prefix('[').and_then(|token| token.strip_suffix(']'));
    if let Some(name) = in_brackets.filter(|name| !name.is_empty() && name.chars().all(char::is_alphanumeric)) {
        return error(message, location, format!("a section has no brackets around its name: `{name}: {{ ... }}`"));
    }
    error(message, location, "a field is written `name: value`, its name without quotes")
}

pub(super) fn quoted_name(location: &Location, name: &str) -> Diagnostic {
    error("the name of a field has no quotes", location, format!("write `{name}: ...`"))
}

pub(super) fn list_with_names(location: &Location, open: &Location) -> Diagnostic {
    error("a list in `[ ]` has no names", location, "entries with names stand in `{ }`")
        .also(open, "`[` is opened here")
}

pub(super) fn too_deep(open: &Location) -> Diagnostic {
    error("brackets are nested too deeply", open, "a pipeline needs about five levels of brackets")
}

pub(super) fn no_parenthesis(location: &Location, kind: &str) -> Diagnostic {
    error(format!("`(` is missing after {}", quote(kind)), location, format!("write `{kind}(...)`"))
}

pub(super) fn value_with_parenthesis(location: &Location, value: &str) -> Diagnostic {
    let message = format!("`{value}` is a value and no name: a parenthesis cannot follow");
    Diagnostic::error("syntax", message).at(location, "")
}

/// A bracket that is closed by one of another kind.
pub(super) fn wrong_close(open: &Location, inner: Bracket, at: &Location, close: Bracket) -> Diagnostic {
    let (opened, fitting, found) = (inner.open(), inner.close(), close.close());
    error(format!("`{opened}` is closed by `{found}`"), at, format!("write `{fitting}` in place of `{found}`"))
        .also(open, format!("`{opened}` is opened here"))
}

/// A closing bracket without an opening one, inside of an open one.
pub(super) fn extra_close(open: &Location, inner: Bracket, at: &Location, close: Bracket) -> Diagnostic {
    let (opened, found) = (inner.open(), close.close());
    error(format!("`{found}` closes nothing"), at, format!("delete the `{found}`"))
        .also(open, format!("only `{opened}` is open here"))
}

/// A bracket that is not closed where something begins that cannot be inside of it.
pub(super) fn unclosed(open: &Location, inner: Bracket, next: &Location) -> Diagnostic {
    let (opened, close) = (inner.open(), inner.close());
    let message = format!("`{opened}` is not closed");
    error(message, open, format!("close it with `{close}`")).also(next, format!("`{close}` is missing before this"))
}

/// Brackets that are open at the end of the file, the outermost first.
pub(super) fn unclosed_at_end(open: &[(Location, Bracket)]) -> Option<Diagnostic> {
    let ((location, inner), outer) = open.split_last()?;
    let closes: String = open.iter().rev().map(|(_, bracket)| bracket.close()).collect();
    let message = format!("`{}` is not closed: the file ends too early", inner.open());
    let mut diagnostic = error(message, location, format!("end the file with `{closes}`"));
    for (location, bracket) in outer {
        diagnostic = diagnostic.also(location, format!("`{}` is not closed either", bracket.open()));
    }
    Some(diagnostic)
}

/// Error of text after the one value of a file, which may have a name.
pub(super) fn after_the_end(location: &Location, token: &str, name: Option<&str>) -> Diagnostic {
    let value = name.map_or_else(|| "value".to_owned(), |name| quote(&format!("{name}( ... )")));
    let end = name.map_or_else(|| "the value".to_owned(), |_| value.clone());
    let message = format!("after the end of {end}, {}", found(token));
    error(message, location, format!("a file holds one {value} and nothing after it"))
}

pub(super) fn too_long(start: &Location, bytes: usize, max: usize) -> Diagnostic {
    Diagnostic::error("file-too-long", format!("the file has {bytes} bytes, more than a pipeline can have"))
        .at(start, "")
        .help(format!("a pipeline file has at most {max} bytes"))
}

pub(super) fn blank(start: &Location) -> Diagnostic {
    const SMALLEST: &str = "the smallest pipeline is `Pipeline(inputs: { \"scene\": Color }, nodes: {}, \
                            outputs: { \"display\": \"scene\" })`";
    Diagnostic::error("empty-file", "the file is empty").at(start, "").help(SMALLEST)
}
