//! Which bracket is the wrong one, where an opening and a closing bracket do not fit.

use std::sync::Arc;

use super::bracket::Bracket;
use super::token::{Kind, Lexer, Token};

/// For each bracket, how many closing ones of a file are too many; negative where they are too few.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Balance([i64; Bracket::ALL.len()]);

/// What is wrong about a closing bracket that does not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Misfit {
    /// It is meant to close the bracket that is open, and of the wrong kind.
    Wrong,
    /// It closes an outer bracket; the one that is open is not closed.
    Unclosed,
    /// It closes nothing.
    Extra,
}

impl Balance {
    pub(super) fn of(file: &Arc<str>, text: &str) -> Self {
        let mut balance = Self::default();
        let mut lexer = Lexer::new(file, text);
        loop {
            match lexer.next().kind {
                Kind::Open(bracket) => balance.0[bracket as usize] -= 1,
                Kind::Close(bracket) => balance.0[bracket as usize] += 1,
                Kind::End => return balance,
                _ => {}
            }
        }
    }

    /// Whether closing brackets of this kind are missing.
    pub(super) fn lacks(&self, bracket: Bracket) -> bool {
        self.0[bracket as usize] < 0
    }

    /// Whether there are too many closing brackets of this kind.
    pub(super) fn exceeds(&self, bracket: Bracket) -> bool {
        self.0[bracket as usize] > 0
    }

    /// Why `close` does not fit the last of the `open` brackets.
    pub(super) fn misfit(&self, open: &[Token], inner: Bracket, close: (&Token, Bracket)) -> Misfit {
        let Some((last, outer)) = open.split_last() else { return Misfit::Extra };
        let (close, bracket) = close;
        let partners = || outer.iter().filter(|token| token.kind == Kind::Open(bracket));
        let is_first = close.is_first_on_line();
        // A closing bracket that begins a line stands below the line that it closes.
        if is_first && last.indent > close.indent && partners().any(|token| token.indent == close.indent) {
            return Misfit::Unclosed;
        }
        // One on a line with the open bracket, and with no other that it could close, is meant for it.
        let shares_line = last.line == close.line;
        if shares_line && partners().all(|token| token.line != close.line) {
            return Misfit::Wrong;
        }
        let has_partner = partners().next().is_some();
        match (self.lacks(inner), self.exceeds(bracket)) {
            (true, true) => Misfit::Wrong,
            (true, false) if has_partner => Misfit::Unclosed,
            (false, true) => Misfit::Extra,
            _ if shares_line => Misfit::Wrong,
            _ if has_partner && is_first => Misfit::Unclosed,
            _ => Misfit::Extra,
        }
    }

    /// Takes note that a missing closing bracket has been found, so that it does not explain the next misfit too.
    pub(super) fn found_missing(&mut self, bracket: Bracket) {
        self.0[bracket as usize] += 1;
    }

    /// Takes note that a closing bracket without an opening one has been found.
    pub(super) fn found_extra(&mut self, bracket: Bracket) {
        self.0[bracket as usize] -= 1;
    }
}

/// Whether a token begins an entry of an outer bracket, since it begins a line that is indented no more than the line
/// on which `open` stands.
pub(super) fn is_outside(open: &Token, token: &Token) -> bool {
    token.is_first_on_line() && token.line > open.line && token.indent <= open.indent
}
