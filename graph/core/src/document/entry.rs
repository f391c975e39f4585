//! Single entries of maps, and single fields of nodes: one goes, or comes between others. All bytes around it stay,
//! comments among them, so that an entry that came and goes leaves the text of before.

use std::ops::Range;

use super::edit::{Layout, map_at, replaced, tree, with_entry};
use super::token::Kind;
use super::tree::Tree;

/// The text without the entry whose value begins at that byte.
pub(crate) fn without_entry(text: &str, value: usize) -> String {
    let layout = Layout::new(text);
    let Some(entry) = layout.entry(value) else { return text.to_owned() };
    let [before, key, last, after] =
        [entry.start - 1, entry.start, entry.end - 1, entry.end].map(|index| layout.tokens[index]);
    let comma = Some(after).filter(|after| after.kind == Kind::Comma);
    let end = comma.map_or(last.end, |comma| comma.end);
    let is_blank = |span: Range<usize>| text[span].trim().is_empty();
    let has_blank_gap = comma.is_none_or(|comma| is_blank(last.end..comma.start));
    let without = |span: Range<usize>| replaced(text, span, "");
    let without_comma_before = |text: String| match before.kind {
        Kind::Comma => replaced(&text, before.start..before.end, ""),
        _ => text,
    };
    let next = layout.tokens[entry.end + usize::from(comma.is_some())];
    if matches!((before.kind, next.kind), (Kind::Open(_), Kind::Close(_)))
        && is_blank(before.end..key.start)
        && has_blank_gap
        && is_blank(end..next.start)
    {
        return without(before.end..next.start);
    }
    let (begins_line, next_line) = (layout.begins_line(&key), text[end..].find('\n').map(|at| end + at + 1));
    match (next_line, comma) {
        // It has its lines for itself.
        (Some(next_line), _) if begins_line && has_blank_gap && is_blank(end..next_line) => {
            let shorter = without(key.line..next_line);
            if comma.is_some() { shorter } else { without_comma_before(shorter) }
        }
        _ if before.kind == Kind::Comma && !begins_line && is_blank(before.end..key.start) => {
            without(before.start..last.end)
        }
        (_, Some(_)) if has_blank_gap => {
            without(key.start..text.len() - text[end..].trim_start_matches([' ', '\t']).len())
        }
        (_, Some(comma)) => replaced(&without(comma.start..comma.end), key.start..last.end, ""),
        (_, None) if begins_line => without_comma_before(without(key.start..last.end)),
        (_, None) => {
            let start = text[..key.start].trim_end_matches([' ', '\t']).len();
            without_comma_before(without(start..last.end))
        }
    }
}

/// The text with an entry after the one whose value begins at that byte.
pub(crate) fn with_entry_after(text: &str, value: usize, entry: &str) -> String {
    let layout = Layout::new(text);
    let Some(found) = layout.entry(value) else { return text.to_owned() };
    let [key, last, after] = [found.start, found.end - 1, found.end].map(|index| layout.tokens[index]);
    let has_comma = after.kind == Kind::Comma;
    let end = if has_comma { after.end } else { last.end };
    let Some(next_line) = next_line(text, end).filter(|_| layout.begins_line(&key)) else {
        return replaced(text, last.end..last.end, &format!(", {entry}"));
    };
    let comma = if has_comma { "," } else { "" };
    let line = format!("{}{entry}{comma}{}", layout.indent(&key), line_end(text, next_line));
    let longer = replaced(text, next_line..next_line, &line);
    if has_comma { longer } else { replaced(&longer, last.end..last.end, ",") }
}

/// The text with an entry before all others of a section.
pub(crate) fn with_first_entry(text: &str, section: &str, entry: &str) -> String {
    let layout = Layout::new(text);
    let (place, found) = map_at(&tree(text), &[section]);
    let brackets = layout.brackets(place).filter(|(open, close)| found == 1 && open + 1 < *close);
    let Some((open, _)) = brackets else { return with_entry(text, &[section], entry) };
    let [open, first] = [open, open + 1].map(|index| layout.tokens[index]);
    match next_line(text, open.end).filter(|_| layout.begins_line(&first)) {
        Some(next_line) => {
            let line = format!("{}{entry},{}", layout.indent(&first), line_end(text, next_line));
            replaced(text, next_line..next_line, &line)
        }
        None => replaced(text, first.start..first.start, &format!("{entry}, ")),
    }
}

/// The text without a section that has no entries.
pub(crate) fn without_empty_section(text: &str, section: &str) -> String {
    let Tree::Struct(_, fields) = tree(text).value else { return text.to_owned() };
    let is_empty = |value: &Tree| matches!(value, Tree::Map(map) if map.entries.is_empty());
    let found = fields.entries.iter().find(|(name, item)| name.value == section && is_empty(&item.value));
    found.map_or_else(|| text.to_owned(), |(_, item)| without_entry(text, item.location.start))
}

/// The first byte of the line after a place, if nothing but a comment is between.
fn next_line(text: &str, from: usize) -> Option<usize> {
    let next = from + text[from..].find('\n')? + 1;
    let rest = text[from..next].trim();
    let is_comment = rest.starts_with("//") || rest.starts_with("/*") && rest.find("*/") == Some(rest.len() - 2);
    (rest.is_empty() || is_comment).then_some(next)
}

/// The end of the line before the one that begins at that byte.
fn line_end(text: &str, line: usize) -> &'static str {
    if text[..line].ends_with("\r\n") { "\r\n" } else { "\n" }
}

impl Layout<'_> {
    /// The tokens of the entry whose value begins at a byte, its comma not among them.
    fn entry(&self, value: usize) -> Option<Range<usize>> {
        let first = self.tokens.partition_point(|token| token.start < value);
        let mut depth = 0_usize;
        let length = self.tokens[first..].iter().position(|token| {
            match token.kind {
                Kind::Open(_) => depth += 1,
                Kind::Close(_) if depth > 0 => depth -= 1,
                Kind::Close(_) | Kind::Comma => return depth == 0,
                _ => {}
            }
            false
        })?;
        // The name and the colon are before the value, and a bracket or a comma before them.
        (first > 2).then(|| first - 2..first + length)
    }
}

#[cfg(test)]
mod tests {
    use super::{with_entry_after, with_first_entry, without_empty_section, without_entry};

    /// Texts with an entry `"a"` in `nodes`, with another one after it, and with another one before all.
    const LAYOUTS: [(&str, &str, &str); 10] = [
        (r#"P(nodes: { "a": A })"#, r#"P(nodes: { "a": A, "n": N(x: 1) })"#, r#"P(nodes: { "n": N(x: 1), "a": A })"#),
        (r#"P(nodes: {"a":A(),})"#, r#"P(nodes: {"a":A(), "n": N(x: 1),})"#, r#"P(nodes: {"n": N(x: 1), "a":A(),})"#),
        (
            r#"P(nodes: { "a": A(b: (1, 2)), "b": B })"#,
            r#"P(nodes: { "a": A(b: (1, 2)), "n": N(x: 1), "b": B })"#,
            r#"P(nodes: { "n": N(x: 1), "a": A(b: (1, 2)), "b": B })"#,
        ),
        (
            "P(\n  nodes: {\n    \"a\": A,\n    \"b\": B,\n  },\n)",
            "P(\n  nodes: {\n    \"a\": A,\n    \"n\": N(x: 1),\n    \"b\": B,\n  },\n)",
            "P(\n  nodes: {\n    \"n\": N(x: 1),\n    \"a\": A,\n    \"b\": B,\n  },\n)",
        ),
        (
            "P(\r\n\tnodes: {\r\n\t\t\"a\": A(\r\n\t\t\tx: 1,\r\n\t\t) // c, }\r\n\t})",
            "P(\r\n\tnodes: {\r\n\t\t\"a\": A(\r\n\t\t\tx: 1,\r\n\t\t), // c, }\r\n\t\t\"n\": N(x: 1)\r\n\t})",
            "P(\r\n\tnodes: {\r\n\t\t\"n\": N(x: 1),\r\n\t\t\"a\": A(\r\n\t\t\tx: 1,\r\n\t\t) // c, }\r\n\t})",
        ),
        (
            "P(nodes: {\n  // of a\n  \"a\": A, /* c */\n  // of b\n  \"b\": B\n})",
            "P(nodes: {\n  // of a\n  \"a\": A, /* c */\n  \"n\": N(x: 1),\n  // of b\n  \"b\": B\n})",
            "P(nodes: {\n  \"n\": N(x: 1),\n  // of a\n  \"a\": A, /* c */\n  // of b\n  \"b\": B\n})",
        ),
        (
            "P(nodes: {\n  \"a\": A, \"b\": B,\n})",
            "P(nodes: {\n  \"a\": A, \"n\": N(x: 1), \"b\": B,\n})",
            "P(nodes: {\n  \"n\": N(x: 1),\n  \"a\": A, \"b\": B,\n})",
        ),
        (
            "P(nodes: {\n  \"b\": B, \"a\": A,\n})",
            "P(nodes: {\n  \"b\": B, \"a\": A, \"n\": N(x: 1),\n})",
            "P(nodes: {\n  \"n\": N(x: 1),\n  \"b\": B, \"a\": A,\n})",
        ),
        (
            "P(nodes: {\n  \"a\": A, /* c\n */ \"b\": B,\n})",
            "P(nodes: {\n  \"a\": A, \"n\": N(x: 1), /* c\n */ \"b\": B,\n})",
            "P(nodes: {\n  \"n\": N(x: 1),\n  \"a\": A, /* c\n */ \"b\": B,\n})",
        ),
        (
            "P(nodes: {\n  \"b\": B, \"a\": A\n})",
            "P(nodes: {\n  \"b\": B, \"a\": A, \"n\": N(x: 1)\n})",
            "P(nodes: {\n  \"n\": N(x: 1),\n  \"b\": B, \"a\": A\n})",
        ),
    ];

    fn value_of(text: &str, name: &str) -> usize {
        let key = text.find(&format!("\"{name}\"")).expect("the entry is there");
        let after = key + name.len() + 3;
        after + text[after..].find(|c: char| !c.is_whitespace()).expect("it has a value")
    }

    #[test]
    fn an_entry_that_comes_and_goes_leaves_the_text_of_before() {
        for (text, after, first) in LAYOUTS {
            let longer = with_entry_after(text, value_of(text, "a"), "\"n\": N(x: 1)");
            assert_eq!(longer, after, "{text}");
            assert_eq!(without_entry(&longer, value_of(&longer, "n")), text);
            let longer = with_first_entry(text, "nodes", "\"n\": N(x: 1)");
            assert_eq!(longer, first, "{text}");
            assert_eq!(without_entry(&longer, value_of(&longer, "n")), text);
        }
    }

    #[test]
    fn comments_stay_where_an_entry_goes() {
        for (text, after) in [
            (
                "P(set: {\n  // of a\n  \"a\": On, // c\n  \"b\": On,\n})",
                "P(set: {\n  // of a\n  // c\n  \"b\": On,\n})",
            ),
            ("P(set: { \"b\": On, /* c */ \"a\": On /* d */ })", "P(set: { \"b\": On /* c */ /* d */ })"),
            ("P(set: { /* c */ \"a\": On })", "P(set: { /* c */ })"),
            ("P(set: {\n  \"a\": On,\n})", "P(set: {})"),
            ("P(x: 1, set: {\"a\": On,})", "P(x: 1, set: {})"),
        ] {
            assert_eq!(without_entry(text, value_of(text, "a")), after, "{text}");
        }
    }

    #[test]
    fn an_empty_section_goes() {
        for (text, after) in [
            ("P(x: 1, set: {})", "P(x: 1)"),
            ("P(\n  x: 1,\n  set: { },\n)", "P(\n  x: 1,\n)"),
            ("P(set: { /* c */ \"a\": On })", "P(set: { /* c */ \"a\": On })"),
        ] {
            assert_eq!(without_empty_section(text, "set"), after, "{text}");
        }
        assert_eq!(with_first_entry("P(nodes: {})", "nodes", "\"n\": N"), "P(nodes: { \"n\": N })");
    }
}
