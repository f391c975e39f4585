//! Texts as words, numbers, strings and signs, so that mutation can exchange like for like.

use std::ops::Range;

/// The class of a piece of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    Word,
    Number,
    /// In quotation marks.
    String,
    Space,
    LineEnd,
    Sign,
}

/// A piece of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) class: Class,
    pub(crate) text: String,
}

impl Token {
    pub(crate) fn new(text: &str) -> Self {
        let class = text.chars().next().map_or(Class::Space, |first| class(first, text.chars().nth(1)));
        Self { class, text: text.to_owned() }
    }
}

fn class(c: char, next: Option<char>) -> Class {
    let begins_number = next.is_some_and(|next| next.is_ascii_digit() || next == '.');
    match c {
        '"' => Class::String,
        '\n' => Class::LineEnd,
        '+' | '-' | '.' if begins_number => Class::Number,
        _ if c.is_ascii_digit() => Class::Number,
        _ if c.is_alphanumeric() || c == '_' || c == '@' => Class::Word,
        _ if c.is_whitespace() => Class::Space,
        _ => Class::Sign,
    }
}

/// The pieces of a text; joined they are the text.
pub(crate) fn tokens(text: &str) -> Vec<Token> {
    let mut rest = text;
    let mut all = Vec::new();
    while let Some(first) = rest.chars().next() {
        let class = class(first, rest.chars().nth(1));
        let (token, after) = rest.split_at(length(rest, first, class));
        all.push(Token { class, text: token.to_owned() });
        rest = after;
    }
    all
}

/// Bytes of the token at the beginning of a text.
fn length(text: &str, first: char, class: Class) -> usize {
    let begin = first.len_utf8();
    let until = |ends: &dyn Fn(char) -> bool| text[begin..].find(ends).map_or(text.len(), |at| begin + at);
    match class {
        Class::Word => until(&|c| !(c.is_alphanumeric() || c == '_')),
        Class::Number => until(&|c| !(c.is_alphanumeric() || matches!(c, '.' | '+' | '-'))),
        Class::String => (until(&|c| c == '"' || c == '\n') + 1).min(text.len()),
        Class::Space => until(&|c| !c.is_whitespace() || c == '\n'),
        Class::LineEnd | Class::Sign => begin,
    }
}

/// The group around or after a token: from an opening bracket to its end, or to the end of the line.
pub(crate) fn group(tokens: &[Token], from: usize) -> Range<usize> {
    let mut depth = 0_usize;
    for (index, token) in tokens.iter().enumerate().skip(from) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 && (token.class == Class::LineEnd || matches!(token.text.as_str(), ")" | "]" | "}" | ",")) {
            return from..index + 1;
        }
    }
    from..tokens.len()
}

#[cfg(test)]
mod tests {
    use super::{Class, group, tokens};

    #[test]
    fn tokens_join_to_their_text() {
        let text = "Pipeline(nodes: { \"a\": Tint(by: -1.5e-3) }, // ä\n \"open";
        let all = tokens(text);
        assert_eq!(all.iter().map(|token| token.text.as_str()).collect::<String>(), text);
        let numbers: Vec<&str> =
            all.iter().filter(|token| token.class == Class::Number).map(|token| token.text.as_str()).collect();
        assert_eq!(numbers, ["-1.5e-3"]);
    }

    #[test]
    fn a_group_ends_with_its_bracket() {
        let all = tokens("a(b, (c)) d\ne");
        let text =
            |range: std::ops::Range<usize>| all[range].iter().map(|token| token.text.as_str()).collect::<String>();
        assert_eq!(text(group(&all, 0)), "a(b, (c))");
        assert_eq!(text(group(&all, 9)), " d\n");
    }
}
