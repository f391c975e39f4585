//! The lines of a table's text file, and the numbers in them.

use afterimage_graph::document::without_mark;

use super::LutError;

/// The content of a line.
pub(crate) enum Line<'a> {
    /// A keyword and the rest of its line.
    Keyword(&'a str, &'a str),
    /// An entry of the table.
    Entry([f32; 3]),
}

/// The lines that are neither blank nor comments, with their numbers from 1.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> + Clone {
    let text = without_mark(text);
    // Classic Mac OS ends lines with a carriage return. In files with CR LF the return is whitespace at the end of the
    // line.
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let say = |(index, line)| (index + 1, content(line));
    text.split(separator).enumerate().map(say).filter(|(_, line)| !line.is_empty())
}

/// The line without its comment. A `#` in a quoted title is part of the title.
fn content(line: &str) -> &str {
    let is_title = line.trim_start().starts_with("TITLE");
    let line = if is_title { line } else { line.split('#').next().unwrap_or_default() };
    line.trim()
}

pub(crate) fn read(number: usize, line: &str) -> Result<Line<'_>, LutError> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    if is_keyword(word) {
        return Ok(Line::Keyword(word, rest.trim()));
    }
    numbers(number, line, "an entry").map(Line::Entry)
}

/// Parses exactly `N` finite numbers.
pub(crate) fn numbers<const N: usize>(number: usize, text: &str, what: &str) -> Result<[f32; N], LutError> {
    let mut found = [0.0; N];
    let mut words = text.split_ascii_whitespace();
    for (index, slot) in found.iter_mut().enumerate() {
        let word = words.next().ok_or_else(|| count(number, what, N, index))?;
        *slot = finite(number, word)?;
    }
    match words.count() {
        0 => Ok(found),
        more => Err(count(number, what, N, N + more)),
    }
}

fn count(number: usize, what: &str, expected: usize, found: usize) -> LutError {
    LutError::new(number, format!("{what} has {expected} numbers, not {found}"))
}

fn finite(number: usize, word: &str) -> Result<f32, LutError> {
    match word.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(LutError::new(number, format!("`{}` is not finite", short(word)))),
        Err(_) => Err(LutError::new(number, format!("`{}` is not a number", short(word)))),
    }
}

/// Keywords are in capitals. `nan` and `inf` are numbers that are not finite.
fn is_keyword(word: &str) -> bool {
    let capital = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    word.starts_with(|c: char| c.is_ascii_uppercase()) && word.chars().all(capital) && word.parse::<f32>().is_err()
}

/// A word of the file, shortened for a message.
pub(crate) fn short(word: &str) -> String {
    const MOST: usize = 24;
    if word.chars().count() <= MOST { word.to_owned() } else { word.chars().take(MOST).chain(['…']).collect() }
}
