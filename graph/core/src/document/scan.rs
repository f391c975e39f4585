//! Tokens of a text that may have errors, for editors that color and complete it.

use std::ops::Range;
use std::sync::Arc;

use super::token::{Kind, Lexer};

/// Kind of a [`TextToken`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// A name without quotes.
    Name,
    /// A number.
    Number,
    /// A text in quotes.
    Text,
    /// A text without its closing quote.
    OpenText,
    /// An opening bracket.
    Open,
    /// A closing bracket.
    Close,
    /// A colon.
    Colon,
    /// A comma.
    Comma,
    /// Characters that no pipeline uses.
    Other,
}

/// A token of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextToken {
    /// Its kind.
    pub kind: TokenKind,
    /// Its bytes.
    pub span: Range<usize>,
}

/// The tokens of a text, with space and comments between them. They end early where a text is no RON at all.
pub fn tokens(text: &str) -> Vec<TextToken> {
    let file = Arc::from("");
    let mut lexer = Lexer::new(&file, text);
    let mut found = Vec::new();
    loop {
        let token = lexer.next();
        let kind = match token.kind {
            Kind::End => return found,
            Kind::Word => TokenKind::Name,
            Kind::Number => TokenKind::Number,
            Kind::Text | Kind::ForeignText => TokenKind::Text,
            Kind::BrokenText => TokenKind::OpenText,
            Kind::Open(_) => TokenKind::Open,
            Kind::Close(_) => TokenKind::Close,
            Kind::Colon => TokenKind::Colon,
            Kind::Comma => TokenKind::Comma,
            Kind::Literal | Kind::Stray => TokenKind::Other,
        };
        found.push(TextToken { kind, span: token.start..token.end });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_with_errors_has_tokens_and_comments_are_between_them() {
        let text = "Pipeline( // a \"comment\"\n  x: 0.5ev, /* y: */ \"ab";
        let found: Vec<(TokenKind, &str)> =
            tokens(text).into_iter().map(|token| (token.kind, &text[token.span])).collect();
        use TokenKind::{Colon, Comma, Name, Number, Open, OpenText};
        let wanted = [
            (Name, "Pipeline"),
            (Open, "("),
            (Name, "x"),
            (Colon, ":"),
            (Number, "0.5ev"),
            (Comma, ","),
            (OpenText, "\"ab"),
        ];
        assert_eq!(found, wanted);
    }
}
