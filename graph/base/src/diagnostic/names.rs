//! Names in messages: in one line, quoted, listed, and the nearest to a wrong one.

use std::borrow::Cow;
use std::path::Path;

/// Returns whether a character can forge a line, change the state of a terminal, or reverse the order of what follows:
/// control characters, separators of lines, and the controls of bidirectional text (Unicode UAX 9, 2).
pub const fn is_control(c: char) -> bool {
    matches!(
        c,
        '\0'..='\u{1f}'
            | '\u{7f}'..='\u{9f}'
            | '\u{61c}'
            | '\u{200e}'
            | '\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2066}'..='\u{2069}'
    )
}

/// A text of a file or of an argument as a part of one line: control characters are escapes, which mean the same in
/// JSON.
pub fn shown(text: &str) -> Cow<'_, str> {
    if !text.contains(is_control) {
        return text.into();
    }
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => line += "\\n",
            '\r' => line += "\\r",
            '\t' => line += "\\t",
            c if is_control(c) => line += &format!("\\u{:04x}", u32::from(c)),
            c => line.push(c),
        }
    }
    line.into()
}

/// The name of a file as a part of one line.
pub fn shown_path(path: &Path) -> String {
    shown(&path.to_string_lossy()).into_owned()
}

/// A name in backticks for a message: shortened, and without control characters.
pub fn quote(name: &str) -> String {
    const MAX_LENGTH: usize = 48;
    let shown: String = name.chars().take(MAX_LENGTH).flat_map(char::escape_debug).collect();
    // Quotes inside backticks need no escape of their own.
    let shown = shown.replace("\\'", "'").replace("\\\"", "\"");
    if name.chars().nth(MAX_LENGTH).is_some() { format!("`{shown}…`") } else { format!("`{shown}`") }
}

/// A list of names for a message: `a`, `b` and `c`; at most `max` of them.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>, max: usize) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(max).map(quote).collect();
    match (shown.split_last(), names.count()) {
        (None, 0) => String::new(),
        (Some((only, [])), 0) => only.clone(),
        (Some((last, rest)), 0) => format!("{} and {last}", rest.join(", ")),
        (_, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// "did you mean `x`?" with the nearest of the names, if one is near enough.
pub fn did_you_mean<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(wrong, names).map(|name| format!("did you mean {}?", quote(name)))
}

/// The name nearest to `wrong`, if at most a third of the letters of `wrong` differ, or one begins with the other.
pub fn nearest<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    equally_near(wrong, names).first().copied()
}

/// The names nearest to `wrong`, sorted, each once; none if more than a third of the letters of `wrong` differ.
pub(super) fn equally_near<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    const MAX_LENGTH: usize = 64;
    if wrong.len() > MAX_LENGTH {
        return Vec::new();
    }
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let meant = plain(wrong);
    let allowed = (wrong.chars().count() / 3).max(1);
    let distance = |name: &str| {
        let plain = plain(name);
        let is_beginning = meant.len() >= 4 && plain.starts_with(&meant);
        // `ToneMapping` for `ToneMap`.
        let is_longer = plain.len() >= 5 && meant.len() < 2 * plain.len() && meant.starts_with(&plain);
        match strsim::damerau_levenshtein(&meant, &plain) {
            _ if is_beginning => 1,
            distance if is_longer => distance.min(allowed),
            distance => distance,
        }
    };
    let near = names.into_iter().filter(|name| name.len() <= MAX_LENGTH).map(|name| (distance(name), name));
    let mut near: Vec<(usize, &str)> = near.filter(|(distance, _)| *distance <= allowed).collect();
    near.sort_unstable();
    near.dedup();
    let least = near.first().map(|(distance, _)| *distance);
    near.into_iter().take_while(|(distance, _)| Some(*distance) == least).map(|(_, name)| name).collect()
}
