//! Ends of quoted texts, and the quote that is not closed.
//!
//! A text of RON may run over lines, so a quote that is missing turns all that follows inside out. Texts of pipelines
//! hardly ever do. A line on which a text begins that does not end there has one quote too few, unless that text is
//! followed by what can follow a text.

/// Quotes that word processors and other languages write.
pub(super) fn is_foreign_quote(c: char) -> bool {
    const FOREIGN: &str = "'\u{201c}\u{201d}\u{201e}\u{2018}\u{2019}\u{ab}\u{bb}";
    FOREIGN.contains(c)
}

/// The end of the text whose quote is at `start`.
pub(super) fn text_end(text: &str, start: usize) -> Option<usize> {
    let mut is_escaped = false;
    let end = text.as_bytes()[start + 1..].iter().position(|byte| {
        let is_end = *byte == b'"' && !is_escaped;
        is_escaped = *byte == b'\\' && !is_escaped;
        is_end
    });
    end.map(|at| start + 1 + at + 1)
}

/// The end of a raw text whose first `#` or quote is at `start`.
pub(super) fn raw_end(text: &str, start: usize, hashes: usize) -> Option<usize> {
    let inside = start + hashes + 1;
    let end = format!("\"{}", "#".repeat(hashes));
    text[inside..].find(&end).map(|at| inside + at + end.len())
}

/// The end of a text in foreign quotes that is closed on its line.
pub(super) fn foreign_end(text: &str, start: usize) -> Option<usize> {
    let first = text[start..].chars().next()?;
    let inside = start + first.len_utf8();
    let mut is_escaped = false;
    let close = text[inside..].char_indices().find(|(_, c)| {
        let is_end = *c == '\n' || is_foreign_quote(*c) && !is_escaped;
        is_escaped = *c == '\\' && !is_escaped;
        is_end
    });
    close.filter(|(_, c)| *c != '\n').map(|(at, c)| inside + at + c.len_utf8())
}

/// The end of a character in single quotes. It may be a quote or a line break itself.
pub(super) fn character_end(text: &str, start: usize) -> Option<usize> {
    let character = text[start + 1..].chars().next()?;
    let close = start + 1 + character.len_utf8();
    let is_closed = character != '\\' && text[close..].starts_with('\'');
    if is_closed { Some(close + 1) } else { foreign_end(text, start) }
}

/// Bytes after a quote in which the end of its line, and other quotes on it, are looked for: lines of a megabyte must
/// not take the square of that.
const MAX_LINE: usize = 4096;

/// The end of the text whose quote is at `start`.
///
/// # Errors
/// The text is not closed: its likely end.
pub(super) fn plain_end(text: &str, start: usize) -> Result<usize, usize> {
    let far = text.floor_char_boundary(start.saturating_add(MAX_LINE));
    let line_end = text[start..far].find('\n').map_or(far, |at| start + at);
    let are_pairs = |rest: &[u8]| rest.iter().filter(|byte| **byte == b'"').count() % 2 == 0;
    match text_end(text, start) {
        Some(end) if can_follow(&text[end..]) => Ok(end),
        Some(end) if end <= line_end && are_pairs(&text.as_bytes()[end..line_end]) => Ok(end),
        _ => Err(likely_end(text, start, line_end)),
    }
}

/// The likely end of the text that begins at `start` and is not closed on its line.
fn likely_end(text: &str, start: usize, line_end: usize) -> usize {
    let line = &text[start + 1..line_end.max(start + 1)];
    let end = match line.find('"') {
        // The quotes after it are pairs, so the text ends before them.
        Some(next) => separator(&line[..next]).unwrap_or(next),
        None => unmatched_close(line).unwrap_or(line.len()),
    };
    start + 1 + line[..end].trim_end_matches([' ', '\t', '\r', ',']).len()
}

/// Returns whether a text can be followed by this.
fn can_follow(rest: &str) -> bool {
    const FAR: usize = 256;
    let next = rest.chars().take(FAR).find(|c| !c.is_whitespace());
    next.is_none_or(|next| ",:)]}/".contains(next))
}

/// The first comma or colon before a space, or the first closing bracket without an opening one.
fn separator(line: &str) -> Option<usize> {
    let sign = line.match_indices([',', ':']).find(|(at, _)| line[at + 1..].starts_with([' ', '\t']));
    sign.map(|(at, _)| at).into_iter().chain(unmatched_close(line)).min()
}

/// The first closing bracket without an opening one.
fn unmatched_close(line: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, c) in line.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth == 0 => return Some(at),
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
    }
    None
}
