//! The place of the cursor among the brackets of a text, which may have errors.

use std::ops::Range;

use afterimage_graph::document::{TextToken, TokenKind};

/// A pair of brackets around the cursor.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Group {
    /// The word before the opening bracket: the kind of a node.
    pub(super) name: String,
    /// The key of which it is the value: the name of a node or of a section.
    pub(super) key: String,
    /// The keys within.
    pub(super) keys: Vec<String>,
}

/// The brackets around the cursor, and what the text names elsewhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TextPlace {
    /// The outermost first. Empty within a comment.
    pub(super) groups: Vec<Group>,
    /// The key whose value is at the cursor; `None` where a key is.
    pub(super) key: Option<String>,
    /// The bytes of the token that the cursor is in or behind; none between tokens.
    pub(super) token: Range<usize>,
    /// The part of the token before the cursor, without its quote.
    pub(super) typed: String,
    /// The character after the token, with no space between.
    pub(super) next: Option<TokenKind>,
    /// The inputs of the pipeline.
    pub(super) inputs: Vec<String>,
    /// The nodes and their kinds.
    pub(super) nodes: Vec<(String, String)>,
}

/// An open bracket: its group, and the key whose value is next.
struct Open {
    group: usize,
    key: Option<String>,
}

impl TextPlace {
    /// The place at a byte of a text with these tokens.
    pub(super) fn of(text: &str, tokens: &[TextToken], at: usize) -> Self {
        let mut place = Self { token: at..at, ..Self::default() };
        let (mut groups, mut open): (Vec<Group>, Vec<Open>) = (Vec::new(), Vec::new());
        // The open groups at the cursor, once it is reached.
        let mut here: Option<Vec<usize>> = None;
        let mut before: Option<&TextToken> = None;
        for token in tokens {
            if here.is_none() && token.span.end >= at && (token.span.start >= at || is_word(token.kind)) {
                if token.span.start < at {
                    place.token = token.span.clone();
                }
                here = Some(open.iter().map(|open| open.group).collect());
                place.key = open.last().and_then(|open| open.key.clone());
            }
            if let Some(section) = (open.len() == 2).then(|| groups[open[1].group].key.clone()) {
                let key = open[1].key.as_deref();
                match (&*section, token.kind) {
                    ("inputs", TokenKind::Colon) => place.inputs.extend(before.map(|name| word(text, name))),
                    ("nodes", TokenKind::Name) => {
                        place.nodes.extend(key.map(|name| (name.to_owned(), word(text, token))));
                    }
                    _ => {}
                }
            }
            step(text, token, before, &mut groups, &mut open);
            before = Some(token);
        }
        let here = here.unwrap_or_else(|| {
            place.key = open.last().and_then(|open| open.key.clone());
            open.iter().map(|open| open.group).collect()
        });
        if !is_in_comment(text, tokens, at) {
            place.groups = here.into_iter().map(|group| groups[group].clone()).collect();
        }
        if tokens.iter().any(|token| token.span == place.token && token.kind == TokenKind::OpenText) {
            // It goes on to the end of its line, over what it should not hold.
            place.token.end = at;
        }
        place.typed = text[place.token.start..at].trim_start_matches('"').to_owned();
        place.next = tokens.iter().find(|token| token.span.start == place.token.end).map(|token| token.kind);
        place
    }
}

/// Follows a token into groups and out of them.
fn step(text: &str, token: &TextToken, before: Option<&TextToken>, groups: &mut Vec<Group>, open: &mut Vec<Open>) {
    match token.kind {
        TokenKind::Open => {
            let name = before.filter(|before| before.kind == TokenKind::Name);
            let name = name.map_or_else(String::new, |name| word(text, name));
            let key = open.last().and_then(|open| open.key.clone()).unwrap_or_default();
            groups.push(Group { name, key, keys: Vec::new() });
            open.push(Open { group: groups.len() - 1, key: None });
        }
        TokenKind::Close => drop(open.pop()),
        TokenKind::Colon => {
            if let (Some(open), Some(before)) = (open.last_mut(), before) {
                let key = word(text, before);
                groups[open.group].keys.push(key.clone());
                open.key = Some(key);
            }
        }
        TokenKind::Comma => {
            if let Some(open) = open.last_mut() {
                open.key = None;
            }
        }
        _ => {}
    }
}

/// True for tokens that are typed letter by letter.
fn is_word(kind: TokenKind) -> bool {
    matches!(kind, TokenKind::Name | TokenKind::Number | TokenKind::Text | TokenKind::OpenText)
}

/// A token without quotes.
fn word(text: &str, token: &TextToken) -> String {
    text[token.span.clone()].trim_matches('"').to_owned()
}

fn is_in_comment(text: &str, tokens: &[TextToken], at: usize) -> bool {
    let after = tokens.iter().map(|token| token.span.end).filter(|end| *end <= at).max().unwrap_or(0);
    if tokens.iter().any(|token| token.span.start < at && token.span.end > at) {
        return false;
    }
    let gap = &text[after..at];
    let line = gap.rsplit('\n').next().unwrap_or(gap);
    line.contains("//") || gap.matches("/*").count() > gap.matches("*/").count()
}

#[cfg(test)]
mod tests {
    use afterimage_graph::document::tokens;

    use super::*;

    /// The place at the mark `|` of a text.
    fn place(marked: &str) -> TextPlace {
        let at = marked.find('|').expect("the text has a mark");
        let text = marked.replace('|', "");
        TextPlace::of(&text, &tokens(&text), at)
    }

    #[test]
    fn a_place_is_known_while_the_text_has_errors() {
        let kind = place(r#"Pipeline(nodes: { "a": Blur(source: "b"), "c": Vig| }, outputs: {"#);
        assert_eq!((kind.groups.len(), kind.key.as_deref(), &*kind.typed), (2, Some("c"), "Vig"));
        assert_eq!(kind.groups[1].key, "nodes");
        assert_eq!(kind.nodes, [("a".to_owned(), "Blur".to_owned()), ("c".to_owned(), "Vig".to_owned())]);
        let port = place("Pipeline(inputs: { \"x\": Color }, nodes: { \"a\": Blur(|source: \"b\", sigma: 1.0) })");
        assert_eq!((&*port.groups[2].name, &port.groups[2].keys[..]), ("Blur", &["source".into(), "sigma".into()][..]));
        assert_eq!((port.key, port.inputs), (None, vec!["x".to_owned()]));
        let source = place("Pipeline(nodes: {\n \"a\": Blur(source: \"exp|\n \"b\": Blur() })");
        assert_eq!((source.key.as_deref(), &*source.typed), (Some("source"), "exp"));
        assert_eq!(source.token.len(), 4, "the quote that is open, and what was typed");
    }

    #[test]
    fn words_are_replaced_whole_and_comments_are_no_place() {
        let value = place("Pipeline(nodes: { \"a\": ToneMap(curve: Ac|es, x: 1) })");
        assert_eq!((&*value.typed, value.token.len(), value.next), ("Ac", 4, Some(TokenKind::Comma)));
        let behind = place("Pipeline(nodes: { \"a\": ToneMap(|) })");
        assert_eq!((behind.token.len(), behind.next, behind.groups.len()), (0, Some(TokenKind::Close), 3));
        assert!(place("Pipeline( // nodes: |\n)").groups.is_empty());
        assert!(place("Pipeline( /* nodes: | */ )").groups.is_empty());
    }
}
