//! Edits of the text of a pipeline: a value is replaced, or an entry is added in the layout that the text has.
//! Everything else, comments, spacing and line ends included, stays byte for byte.

use std::ops::Range;
use std::sync::Arc;

use super::bracket::Bracket;
use super::parser::read;
use super::token::{Kind, Lexer, Token};
use super::tree::{Item, Tree};

/// The text with a value in place of the one that is written in the span.
pub(crate) fn replaced(text: &str, span: Range<usize>, value: &str) -> String {
    [&text[..span.start], value, &text[span.end..]].concat()
}

/// The places of the numbers of a vector that is written in the span.
pub(crate) fn numbers(text: &str, span: &Range<usize>) -> Vec<Range<usize>> {
    let inside = tokens(text).into_iter().filter(|token| span.start <= token.start && token.end <= span.end);
    inside.filter(|token| token.kind == Kind::Number).map(|token| token.start..token.end).collect()
}

/// The text with a field of the node whose kind begins at that byte.
pub(crate) fn with_field(text: &str, kind: usize, name: &str, value: &str) -> String {
    Layout::new(text).insert(kind, &[], &format!("{name}: {value}"))
}

/// The text with a tier without overrides, unless it has the tier.
pub(crate) fn with_tier(text: &str, tier: &str) -> String {
    let is_there = map_at(&tree(text), &["tiers", tier]).1 == 2;
    if is_there { text.to_owned() } else { with_entry(text, &["tiers"], &format!("{tier:?}: {{}}")) }
}

/// The text with an override in a tier, or in the section `set`.
pub(crate) fn with_override(text: &str, tier: Option<&str>, key: &str, value: &str) -> String {
    let entry = format!("{key:?}: {value}");
    match tier {
        Some(tier) => with_entry(text, &["tiers", tier], &entry),
        None => with_entry(text, &["set"], &entry),
    }
}

/// The text with an entry in the map at a path of names. Maps that are not there are added with it.
pub(crate) fn with_entry(text: &str, path: &[&str], entry: &str) -> String {
    let (place, found) = map_at(&tree(text), path);
    // Names of sections are words, and those in sections are texts.
    let name = |(depth, name): (usize, &&str)| if depth == 0 { (*name).to_owned() } else { format!("{name:?}") };
    let missing: Vec<String> = path.iter().enumerate().map(name).skip(found).collect();
    Layout::new(text).insert(place, &missing, entry)
}

/// Returns whether the pipeline has a section.
pub(crate) fn has_section(text: &str, section: &str) -> bool {
    map_at(&tree(text), &[section]).1 == 1
}

pub(super) fn tree(text: &str) -> Item {
    read(&Arc::from(""), text).tree
}

/// The first byte of the innermost map at a path of names that is there, and how many of the names lead to it.
pub(super) fn map_at(tree: &Item, path: &[&str]) -> (usize, usize) {
    let mut item = tree;
    for (depth, name) in path.iter().enumerate() {
        let is_named = |key: &Item| matches!(&key.value, Tree::Text(text) if text == name);
        let next = match &item.value {
            Tree::Struct(_, fields) => fields.entries.iter().find(|(field, _)| field.value == *name).map(|(_, at)| at),
            Tree::Map(map) => map.entries.iter().find(|(key, _)| is_named(key)).map(|(_, at)| at),
            _ => None,
        };
        match next {
            Some(next) => item = next,
            None => return (item.location.start, depth),
        }
    }
    (item.location.start, path.len())
}

fn tokens(text: &str) -> Vec<Token> {
    let file = Arc::from("");
    let mut lexer = Lexer::new(&file, text);
    std::iter::repeat_with(|| lexer.next()).take_while(|token| token.kind != Kind::End).collect()
}

/// A text with its tokens, and how entries are laid out in it.
pub(super) struct Layout<'a> {
    pub(super) text: &'a str,
    pub(super) tokens: Vec<Token>,
    /// The additional indentation of a level of brackets.
    unit: &'a str,
    line_end: &'static str,
    /// True if the sections of the pipeline have lines of their own.
    is_on_lines: bool,
}

/// The indentation of texts that show none.
const UNIT: &str = "    ";

impl<'a> Layout<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let mut layout = Self { text, tokens: tokens(text), unit: UNIT, line_end: "\n", is_on_lines: false };
        let Some((open, close)) = layout.brackets(tree(text).location.start) else { return layout };
        let close = layout.tokens[close];
        layout.is_on_lines = layout.begins_line(&close);
        layout.line_end = if text[..close.line].ends_with("\r\n") { "\r\n" } else { "\n" };
        let inner = layout.indent(&layout.tokens[open + 1]);
        let unit = inner.strip_prefix(layout.indent(&close)).filter(|unit| !unit.is_empty());
        layout.unit = unit.filter(|_| layout.is_on_lines).unwrap_or(UNIT);
        layout
    }

    /// The tokens of the brackets of what begins at a byte: they are there, or after one name.
    pub(super) fn brackets(&self, start: usize) -> Option<(usize, usize)> {
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

    /// Returns whether there is only space before the token on its line, so that lines can be inserted before it.
    pub(super) fn begins_line(&self, token: &Token) -> bool {
        token.line > 0 && self.text[token.line..token.start].trim().is_empty()
    }

    /// The space that the token's line begins with.
    pub(super) fn indent(&self, token: &Token) -> &'a str {
        let line = &self.text[token.line..token.start];
        &line[..line.find(|c| c != ' ' && c != '\t').unwrap_or(line.len())]
    }

    /// The text with an entry, within new maps of these names, between the brackets of what begins at a byte.
    fn insert(&self, start: usize, maps: &[String], entry: &str) -> String {
        let inline = maps.iter().rev().fold(entry.to_owned(), |inner, name| format!("{name}: {{ {inner} }}"));
        let with = |at: usize, new: &str| replaced(self.text, at..at, new);
        let Some((open, close)) = self.brackets(start) else {
            // A kind without parentheses.
            let name = self.tokens.iter().find(|token| token.start == start);
            return name.map_or(self.text.to_owned(), |name| with(name.end, &format!("({inline})")));
        };
        let is_empty = open + 1 == close;
        let has_comma = self.tokens[close - 1].kind == Kind::Comma;
        let last = self.tokens[close - 1 - usize::from(has_comma)];
        let [open, first, close] = [open, open + 1, close].map(|index| self.tokens[index]);
        if self.begins_line(&close) {
            let has_own_line = first.line > open.line && !is_empty;
            let outer = self.indent(&close);
            let indent = if has_own_line { self.indent(&first).to_owned() } else { format!("{outer}{}", self.unit) };
            let end = if self.text[..close.line].ends_with("\r\n") { "\r\n" } else { "\n" };
            let comma = if is_empty || has_comma { "," } else { "" };
            let line = format!("{indent}{}{comma}{end}", self.on_lines(maps, entry, &indent, end));
            let text = with(close.line, &line);
            return if comma.is_empty() { replaced(&text, last.end..last.end, ",") } else { text };
        }
        let has_gap = open.end < close.start;
        match open.kind {
            _ if !is_empty => with(last.end, &format!(", {inline}")),
            Kind::Open(Bracket::Curly) if self.is_on_lines && !has_gap => {
                let (outer, end) = (self.indent(&open), self.line_end);
                let indent = format!("{outer}{}", self.unit);
                let lines = self.on_lines(maps, entry, &indent, end);
                with(open.end, &format!("{end}{indent}{lines},{end}{outer}"))
            }
            Kind::Open(Bracket::Curly) if has_gap => with(open.end, &format!(" {inline}")),
            Kind::Open(Bracket::Curly) => with(open.end, &format!(" {inline} ")),
            _ => with(open.end, &inline),
        }
    }

    /// An entry within new maps, whose entries have lines of their own.
    fn on_lines(&self, maps: &[String], entry: &str, indent: &str, end: &str) -> String {
        let Some((name, inner)) = maps.split_first() else { return entry.to_owned() };
        let deeper = format!("{indent}{}", self.unit);
        format!("{name}: {{{end}{deeper}{},{end}{indent}}}", self.on_lines(inner, entry, &deeper, end))
    }
}

#[cfg(test)]
mod tests {
    use super::{numbers, replaced, with_field, with_override, with_tier};

    #[test]
    fn fields_follow_the_layout_of_the_node() {
        for (before, after) in [
            ("K", "K(p: 1.0, q: (1, 2))"),
            ("K()", "K(p: 1.0, q: (1, 2))"),
            ("K( )", "K(p: 1.0, q: (1, 2) )"),
            ("K(/* c */)", "K(p: 1.0, q: (1, 2)/* c */)"),
            ("K /* c */ ()", "K /* c */ (p: 1.0, q: (1, 2))"),
            ("K(o: 0)", "K(o: 0, p: 1.0, q: (1, 2))"),
            ("K(o: 0,)", "K(o: 0, p: 1.0, q: (1, 2),)"),
            ("K( o: (0) /* c */ , )", "K( o: (0), p: 1.0, q: (1, 2) /* c */ , )"),
            ("K(o: 0, // c\n  n: 2)", "K(o: 0, // c\n  n: 2, p: 1.0, q: (1, 2))"),
            ("K(o: 0 // c\n /* ) */ )", "K(o: 0, p: 1.0, q: (1, 2) // c\n /* ) */ )"),
            ("K(\n    o: 0,\n)", "K(\n    o: 0,\n    p: 1.0,\n    q: (1, 2),\n)"),
            ("K(\n\to: 0 // c\n)", "K(\n\to: 0, // c\n\tp: 1.0,\n\tq: (1, 2)\n)"),
            ("K(\r\n  o: 0,\r\n)", "K(\r\n  o: 0,\r\n  p: 1.0,\r\n  q: (1, 2),\r\n)"),
            ("K(o: 0, n: 2,\n)", "K(o: 0, n: 2,\n    p: 1.0,\n    q: (1, 2),\n)"),
            ("K(\n  // c\n)", "K(\n  // c\n    p: 1.0,\n    q: (1, 2),\n)"),
        ] {
            let text = |node: &str| format!("Pipeline(nodes: {{ \"a\": {node} }}, outputs: {{}})");
            let kind = text(before).find('K').expect("the node is there");
            let found = with_field(&with_field(&text(before), kind, "p", "1.0"), kind, "q", "(1, 2)");
            assert_eq!(found, text(after), "{before}");
        }
    }

    #[test]
    fn sections_are_made_where_there_are_none() {
        for (before, after) in [
            ("Pipeline()", r#"Pipeline(set: { "a.p": 1.0 }, tiers: { "t": { "b \"c\"": Off } })"#),
            ("Pipeline(x: 1,)", r#"Pipeline(x: 1, set: { "a.p": 1.0 }, tiers: { "t": { "b \"c\"": Off } },)"#),
            (
                "Pipeline(\n  x: 1\n)",
                "Pipeline(\n  x: 1,\n  set: {\n    \"a.p\": 1.0,\n  },\n  tiers: {\n    \"t\": {\n      \
                 \"b \\\"c\\\"\": Off,\n    },\n  }\n)",
            ),
            (
                "Pipeline(\n  set: {},\n  tiers: { \"t\": {} },\n)",
                "Pipeline(\n  set: {\n    \"a.p\": 1.0,\n  },\n  tiers: { \"t\": {\n    \
                 \"b \\\"c\\\"\": Off,\n  } },\n)",
            ),
            (
                "Pipeline(set: {}, tiers: { \"u\": { \"v\": On } })",
                "Pipeline(set: { \"a.p\": 1.0 }, tiers: { \"u\": { \"v\": On }, \"t\": { \"b \\\"c\\\"\": Off } })",
            ),
            (
                "Pipeline(tiers: { \"t\": { } }, set: {\n\"x\": 1,\n})",
                "Pipeline(tiers: { \"t\": { \"b \\\"c\\\"\": Off } }, set: {\n\"x\": 1,\n\"a.p\": 1.0,\n})",
            ),
        ] {
            let set = with_override(before, None, "a.p", "1.0");
            let found = with_override(&set, Some("t"), "b \"c\"", "Off");
            assert_eq!(found, after);
            assert_eq!(with_tier(&found, "t"), found, "the tier is there");
        }
        assert_eq!(with_tier("Pipeline()", "t"), r#"Pipeline(tiers: { "t": {} })"#);
    }

    #[test]
    fn numbers_of_a_vector_are_replaced_alone() {
        let text = "Pipeline(a: 1, b: (1, /* 2 */ -2.5, +3e1,), c: \"x\")";
        let start = text.find("(1,").expect("the vector is there");
        let places = numbers(text, &(start..start + "(1, /* 2 */ -2.5, +3e1,)".len()));
        assert_eq!(places.iter().map(|place| &text[place.clone()]).collect::<Vec<_>>(), ["1", "-2.5", "+3e1"]);
        let found = replaced(text, places[1].clone(), "4.0");
        assert_eq!(found, "Pipeline(a: 1, b: (1, /* 2 */ 4.0, +3e1,), c: \"x\")");
    }
}
