//! The tokens of a text, with one token of lookahead, and the errors found in it.

use std::sync::Arc;

use super::syntax;
use super::token::{Kind, Lexer, Token};
use afterimage_base::diagnostic::{Diagnostic, Location};

pub(super) struct Tokens<'a> {
    pub(super) lexer: Lexer<'a>,
    /// The next token.
    pub(super) next: Token,
    /// The token after it.
    pub(super) second: Token,
    /// The end of the token before it.
    pub(super) end: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(file: &'a Arc<str>, text: &'a str) -> Self {
        let mut lexer = Lexer::new(file, text);
        let (next, second) = (lexer.next(), lexer.next());
        Self { lexer, next, second, end: 0 }
    }

    pub(super) fn advance(&mut self) {
        self.end = self.next.end;
        self.next = std::mem::replace(&mut self.second, self.lexer.next());
    }

    /// Skips to the next comma or closing bracket outside of `depth` brackets, or past the one that ends them.
    pub(super) fn skip(&mut self, mut depth: usize) {
        let is_inside = depth > 0;
        loop {
            match self.next.kind {
                Kind::End => return,
                Kind::Comma | Kind::Close(_) if depth == 0 => return,
                Kind::Open(_) => depth += 1,
                Kind::Close(_) => depth -= 1,
                _ => {}
            }
            self.advance();
            if depth == 0 && is_inside {
                return;
            }
        }
    }

    /// Returns whether the next two tokens are of these kinds.
    pub(super) fn are_next(&self, first: Kind, second: Kind) -> bool {
        self.next.kind == first && self.second.kind == second
    }

    pub(super) fn report(&mut self, error: Diagnostic) {
        self.lexer.errors.push(error);
    }

    /// Reports the next token and skips it.
    pub(super) fn unexpected(&mut self, error: Diagnostic) {
        self.report(error);
        self.advance();
    }

    /// Reports and skips characters that RON does not use. Returns whether there were any.
    pub(super) fn skip_stray(&mut self) -> bool {
        let has_stray = self.next.kind == Kind::Stray;
        while self.next.kind == Kind::Stray {
            self.unexpected(syntax::stray(&self.next_location(), self.next_text()));
        }
        has_stray
    }

    /// Returns whether the last error is about the text at this location.
    pub(super) fn is_reported(&self, location: &Location) -> bool {
        let last = self.lexer.errors.last().and_then(|error| error.labels.first());
        last.is_some_and(|label| label.location == *location)
    }

    pub(super) fn text_of(&self, token: &Token) -> &'a str {
        &self.lexer.text[token.start..token.end]
    }

    /// The next token as it is written; empty at the end of the text.
    pub(super) fn next_text(&self) -> &'a str {
        self.text_of(&self.next)
    }

    pub(super) fn location(&self, start: usize, end: usize) -> Location {
        self.lexer.location(start, end)
    }

    pub(super) fn location_of(&self, token: &Token) -> Location {
        self.location(token.start, token.end)
    }

    pub(super) fn next_location(&self) -> Location {
        self.location_of(&self.next)
    }
}
