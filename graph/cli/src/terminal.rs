//! The only place that writes to the terminal.
//!
//! A control character can clear the screen, change the title, begin a line or reverse what follows, and names and
//! texts of files can hold any. [`say`] and [`note`] print one line, in which all of them are escapes. A text that this
//! program has made of lines keeps its line feeds and its styles; its parts from files have been through [`shown`].
//!
//! A farm takes orders from lines that begin with `openjd_`. Only [`report_to_farm`] prints such a line.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "all output of the program is written here")]

use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::sync::Mutex;

use afterimage_graph::diagnostic::{is_control, shown};
use afterimage_media::FileError;
use clap::error::{ContextKind, ContextValue};

/// The error of standard output.
static OUTPUT_ERROR: Mutex<Option<FileError>> = Mutex::new(None);

/// Prints a line of a result to standard output. A closed pipe is not an error; [`check_output`] returns other errors.
pub(crate) fn say(line: &str) {
    print(&visible(&shown(line)));
}

/// Prints a result of several lines: JSON, the content of a file, or one whose parts from files are [`shown`].
pub(crate) fn say_text(text: &str) {
    print(&visible(text));
}

/// Prints a result that has styles. Its parts from files are [`shown`].
pub(crate) fn say_styled(text: &str) {
    print(&visible_but_styles(text));
}

/// Prints what the session of a farm reads (Open Job Description, "How Jobs Are Run").
pub(crate) fn report_to_farm(what: &str, value: &str) {
    print(&format!("openjd_{what}: {}", shown(value)));
}

fn print(text: &str) {
    let mut out = anstream::stdout().lock();
    let written = writeln!(out, "{}", text.trim_end_matches('\n')).and_then(|()| out.flush());
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && let Ok(mut last) = OUTPUT_ERROR.lock()
    {
        *last = Some(FileError::writing(Path::new("standard output"), &error));
    }
}

/// Returns the error of standard output, if there was one.
pub(crate) fn check_output() -> Result<(), FileError> {
    let error = OUTPUT_ERROR.lock().ok().and_then(|mut error| error.take());
    error.map_or(Ok(()), Err)
}

/// Prints a line that is not a result to standard error.
pub(crate) fn note(line: &str) {
    print_note(&visible(&shown(line)));
}

/// Prints a message that has styles. Its parts from files are [`shown`].
pub(crate) fn note_styled(text: &str) {
    print_note(&visible_but_styles(text));
}

fn print_note(text: &str) {
    let mut out = anstream::stderr().lock();
    let _ = writeln!(out, "{}", text.trim_end_matches('\n'));
}

/// Prints the help, or an error of the arguments. What it quotes of them is [`shown`].
pub(crate) fn print_usage(mut error: clap::Error) {
    let quoted: Vec<(ContextKind, ContextValue)> =
        error.context().filter_map(|(kind, value)| Some((kind, shown_context(value)?))).collect();
    if !quoted.is_empty() {
        // A tip repeats the argument.
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(Vec::new()));
    }
    quoted.into_iter().for_each(|(kind, value)| drop(error.insert(kind, value)));
    let text = error.render();
    match error.use_stderr() {
        true => note_styled(&text.ansi().to_string()),
        false => say_styled(&text.ansi().to_string()),
    }
}

/// The escaped text of an argument; `None` if it needs no escapes.
fn shown_context(value: &ContextValue) -> Option<ContextValue> {
    match value {
        ContextValue::String(text) if text.contains(is_control) => Some(ContextValue::String(shown(text).into_owned())),
        ContextValue::Strings(texts) if texts.iter().any(|text| text.contains(is_control)) => {
            Some(ContextValue::Strings(texts.iter().map(|text| shown(text).into_owned()).collect()))
        }
        _ => None,
    }
}

/// The text in lines that fit the terminal, or into 100 columns, each after `indent` spaces.
pub(crate) fn wrapped(text: &str, indent: usize) -> String {
    let columns = terminal_size::terminal_size().map_or(MAX_COLUMNS, |(width, _)| usize::from(width.0));
    wrapped_to(text, indent, columns.min(MAX_COLUMNS))
}

/// Longer lines are hard to read.
const MAX_COLUMNS: usize = 100;

fn wrapped_to(text: &str, indent: usize, columns: usize) -> String {
    let mut lines = String::new();
    let mut used = usize::MAX;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if used.saturating_add(1 + length) > columns {
            let start = if lines.is_empty() { "" } else { "\n" };
            lines += &format!("{start}{:indent$}{word}", "");
            used = indent + length;
        } else {
            lines += &format!(" {word}");
            used += 1 + length;
        }
    }
    lines
}

/// The text with escapes in place of control characters but line feeds and tabs, and of the first letter of lines that
/// a farm would take for an order. In JSON, where they can be in strings only, the escapes mean the same characters.
fn visible(text: &str) -> String {
    escaped(text, |_| 0)
}

/// The same, with the control characters of colors and other styles.
fn visible_but_styles(text: &str) -> String {
    escaped(text, style_length)
}

/// `kept` is the length of what is kept at the start of a text.
fn escaped(text: &str, kept: fn(&str) -> usize) -> String {
    let mut visible = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let mut rest = line;
        if let Some(order) = line.strip_prefix('o').filter(|order| order.starts_with("penjd_")) {
            visible += "\\u006f";
            rest = order;
        }
        while let Some(c) = rest.chars().next() {
            let length = kept(rest);
            match (length, c) {
                (0, '\n' | '\t') => visible.push(c),
                (0, c) => visible += &shown(c.encode_utf8(&mut [0; 4])),
                (length, _) => visible += &rest[..length],
            }
            rest = &rest[length.max(c.len_utf8())..];
        }
    }
    visible
}

/// The length of the style at the start: `ESC [`, numbers and semicolons, `m` (ECMA-48, SGR); 0 if there is none.
fn style_length(text: &str) -> usize {
    let Some(numbers) = text.strip_prefix("\u{1b}[") else { return 0 };
    let end = numbers.find(|c: char| !c.is_ascii_digit() && c != ';').unwrap_or(numbers.len());
    if numbers[end..].starts_with('m') { end + 3 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        let text = "a\tb\n\r\u{1b}[31m\u{7}\u{0}\u{7f}\u{85}\u{9b}31m\u{202e}\u{2028} é";
        let escaped = "a\tb\n\\r\\u001b[31m\\u0007\\u0000\\u007f\\u0085\\u009b31m\\u202e\\u2028 é";
        assert_eq!(visible(text), escaped);
        assert_eq!(visible(&shown(text)), escaped.replace('\t', "\\t").replace('\n', "\\n"));
    }

    #[test]
    fn styles_stay_and_nothing_else() {
        let styled = "\u{1b}[1m\u{1b}[38;5;9merror\u{1b}[0m: \u{1b}[m";
        assert_eq!(visible_but_styles(styled), styled);
        let text = "\u{1b}[2J\u{1b}]0;title\u{7}\u{1b}[1;2H\u{1b}\u{9b}0m\u{1b}[31\u{1b}[";
        let shown = "\\u001b[2J\\u001b]0;title\\u0007\\u001b[1;2H\\u001b\\u009b0m\\u001b[31\\u001b[";
        assert_eq!(visible_but_styles(text), shown);
    }

    #[test]
    fn no_line_is_an_order_to_a_farm() {
        assert_eq!(
            visible("openjd_fail: a\n openjd_x\nopenjd_status: b"),
            "\\u006fpenjd_fail: a\n openjd_x\n\\u006fpenjd_status: b"
        );
        assert_eq!(visible_but_styles("openjd_fail: a"), "\\u006fpenjd_fail: a");
    }

    #[test]
    fn lines_end_before_the_margin() {
        assert_eq!(wrapped_to("one two three  four\nfive", 0, 9), "one two\nthree\nfour five");
        assert_eq!(wrapped_to("one two", 2, 9), "  one two");
        assert_eq!(wrapped_to("one two", 2, 8), "  one\n  two");
        assert_eq!(wrapped_to("longer than that", 4, 3), "    longer\n    than\n    that");
        assert_eq!(wrapped_to("", 2, 9), "");
    }

    #[test]
    fn json_means_the_same_characters() {
        let text = serde_json::to_string("\u{9b}0m\u{7f}é\u{1b}").expect("a text is JSON");
        assert!(text.contains('\u{9b}'), "only C0 is escaped by the format itself");
        let read: String = serde_json::from_str(&visible(&text)).expect("it is JSON still");
        assert_eq!(read, "\u{9b}0m\u{7f}é\u{1b}");
    }
}
