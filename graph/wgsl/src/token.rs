//! Tokens of WGSL with their places in the text.
//!
//! Signs are single characters: nothing that works on tokens has to tell `<<` from two `<`, or a template list from a
//! comparison.

use unicode_ident::{is_xid_continue, is_xid_start};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A keyword, an identifier, or identifiers that `::` joins.
    Name,
    /// A number with its suffix.
    Number,
    /// A character that is part of nothing else.
    Sign(char),
}

/// A token of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: TokenKind,
    /// The byte where it starts.
    pub(crate) start: u32,
    /// The byte after its end.
    pub(crate) end: u32,
}

impl Token {
    pub(crate) fn of<'t>(&self, text: &'t str) -> &'t str {
        &text[self.start as usize..self.end as usize]
    }

    pub(crate) fn is(&self, sign: char) -> bool {
        self.kind == TokenKind::Sign(sign)
    }
}

/// A block comment without an end: the byte where it starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OpenComment(pub(crate) usize);

/// The tokens of a text, without white space and comments.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token>, OpenComment> {
    let mut lexer = Lexer { text, at: 0, tokens: Vec::with_capacity(text.len() / 4) };
    while let Some(next) = lexer.peek() {
        lexer.token(next)?;
    }
    Ok(lexer.tokens)
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
    tokens: Vec<Token>,
}

impl<'t> Lexer<'t> {
    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn token(&mut self, next: char) -> Result<(), OpenComment> {
        let rest = self.rest();
        if next.is_whitespace() {
            self.at += next.len_utf8();
        } else if rest.starts_with("//") {
            self.at += rest.find(is_line_end).unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            self.at += comment_length(rest).ok_or(OpenComment(self.at))?;
        } else if is_name_start(next) {
            self.push(TokenKind::Name, path_length(rest));
        } else if next.is_ascii_digit() || next == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
            self.push(TokenKind::Number, number_length(rest));
        } else {
            self.push(TokenKind::Sign(next), next.len_utf8());
        }
        Ok(())
    }

    fn push(&mut self, kind: TokenKind, length: usize) {
        let start = self.at;
        self.at += length;
        self.tokens.push(Token { kind, start: start as u32, end: self.at as u32 });
    }
}

/// Returns whether the character ends a line, and with it a comment.
fn is_line_end(c: char) -> bool {
    matches!(c, '\n' | '\u{b}' | '\u{c}' | '\r' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

fn length_while(text: &str, mut belongs: impl FnMut(char) -> bool) -> usize {
    text.find(|c| !belongs(c)).unwrap_or(text.len())
}

/// Bytes of the block comment that the text starts with; comments nest.
fn comment_length(text: &str) -> Option<usize> {
    let mut depth = 0_u32;
    let mut at = 0;
    loop {
        let mark = at + text[at..].find(['/', '*'])?;
        let (step, change) = match &text.as_bytes()[mark..] {
            [b'/', b'*', ..] => (2, 1),
            [b'*', b'/', ..] => (2, -1),
            _ => (1, 0),
        };
        at = mark + step;
        depth = depth.checked_add_signed(change)?;
        if depth == 0 {
            return Some(at);
        }
    }
}

fn is_name_start(c: char) -> bool {
    c == '_' || is_xid_start(c)
}

/// Bytes of the name that the text starts with, and of those that follow it with `::` between.
fn path_length(text: &str) -> usize {
    let mut length = 0;
    loop {
        length += length_while(&text[length..], |c| c == '_' || is_xid_continue(c));
        match text[length..].strip_prefix("::") {
            Some(rest) if rest.starts_with(is_name_start) => length += 2,
            _ => return length,
        }
    }
}

/// Bytes of the number that the text starts with. A sign belongs to it after an exponent's letter.
fn number_length(text: &str) -> usize {
    let is_hex = text.starts_with("0x") || text.starts_with("0X");
    let mut before = '0';
    length_while(text, |c| {
        let exponent = if is_hex { matches!(before, 'p' | 'P') } else { matches!(before, 'e' | 'E') };
        before = c;
        c.is_ascii_alphanumeric() || c == '.' || exponent && matches!(c, '+' | '-')
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn words(text: &str) -> Vec<&str> {
        tokens(text).expect("every comment ends").iter().map(|token| token.of(text)).collect()
    }

    #[test]
    fn comments_and_white_space_separate_tokens_and_are_none() {
        assert_eq!(words("a/**/b // c\n/* d /* e */ f */g\u{2028}h"), ["a", "b", "g", "h"]);
        assert_eq!(words("a // b\u{2028}c"), ["a", "c"]);
        assert_eq!(tokens("a /* b /* c */"), Err(OpenComment(2)));
    }

    #[test]
    fn numbers_are_whole_and_members_are_not_part_of_them() {
        assert_eq!(words("1.5e-3f+0x1.8p+2h-7u"), ["1.5e-3f", "+", "0x1.8p+2h", "-", "7u"]);
        assert_eq!(words("v.x1+.5*a[0].y"), ["v", ".", "x1", "+", ".5", "*", "a", "[", "0", "]", ".", "y"]);
        assert_eq!(words("0xe-1"), ["0xe", "-", "1"]);
    }

    #[test]
    fn names_may_be_of_any_script() {
        assert_eq!(words("Δέλτα_1 réflexion _x"), ["Δέλτα_1", "réflexion", "_x"]);
    }

    #[test]
    fn a_path_without_space_is_one_name() {
        assert_eq!(
            words("a::b1::_c(x)+a:: b a::1 a::"),
            ["a::b1::_c", "(", "x", ")", "+", "a", ":", ":", "b", "a", ":", ":", "1", "a", ":", ":"]
        );
        assert_eq!(words("x: vec2f, y:f32"), ["x", ":", "vec2f", ",", "y", ":", "f32"]);
    }

    proptest! {
        #[test]
        fn any_text_gives_tokens_in_order_that_leave_out_only_comments_and_space(
            text in "(?s)([a-z_0-9.<>(){}/*#:; \n\t]|import |//|/\\*|\\*/|.){0,80}"
        ) {
            if let Ok(tokens) = tokens(&text) {
                let mut end = 0;
                for token in tokens {
                    prop_assert!(token.start >= end && token.end > token.start);
                    prop_assert!(!token.of(&text).contains(char::is_whitespace));
                    end = token.end;
                }
                prop_assert!(end as usize <= text.len());
            }
        }
    }
}
