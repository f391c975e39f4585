//! Recovery after errors.
//!
//! [`Parser::expected`] reports what is missing and continues as if it were there; [`Parser::unexpected`] reports the
//! next token and skips it. Which of them a bracket calls for is decided by the number of brackets in the file
//! ([`Balance`](super::balance::Balance)) and by the lines on which they stand.

use super::bracket::Bracket;
use super::parser::Parser;
use super::syntax;
use super::token::Kind;
use afterimage_base::diagnostic::{Diagnostic, Location};

/// Reason why a closing bracket does not fit the innermost group.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Misfit {
    /// It is meant to close the group, and of the wrong kind.
    Wrong,
    /// It closes an outer group; the innermost one is not closed.
    Unclosed,
    Extra,
}

impl Parser<'_> {
    /// Reports that something is missing before the next token, and continues as if it were there.
    pub(super) fn expected(&mut self, error: Diagnostic) {
        self.report(error);
        self.needs_no_comma = true;
    }

    /// Reports the next token and skips it.
    pub(super) fn unexpected(&mut self, error: Diagnostic) {
        self.report(error);
        self.advance();
    }

    /// Ends the innermost group before the next token; what should follow outside may stand inside of it.
    pub(super) fn expected_close(&mut self, inner: Bracket) {
        self.expected(syntax::unclosed(&self.open_location(), inner, &self.next_location()));
        self.balance.add(inner, 1);
        self.lossy_depth = self.open.len();
        self.has_misfit = true;
    }

    /// Reads a closing bracket of another kind than the innermost group's; whether the group ends with it or before it.
    pub(super) fn unexpected_close(&mut self, inner: Bracket, close: Bracket, has_names: bool) -> bool {
        // Names in a list are reported by themselves.
        let is_meant_as_map = inner == Bracket::Square && close == Bracket::Curly && has_names;
        let misfit = if is_meant_as_map { Misfit::Wrong } else { self.misfit(inner, close) };
        if misfit == Misfit::Unclosed {
            self.expected_close(inner);
            return true;
        }
        self.balance.add(close, -1);
        if misfit == Misfit::Wrong {
            self.balance.add(inner, 1);
        }
        if is_meant_as_map {
            self.advance();
            return true;
        }
        let error = if misfit == Misfit::Wrong { syntax::wrong_close } else { syntax::extra_close };
        self.unexpected(error(&self.open_location(), inner, &self.next_location(), close));
        self.has_misfit = true;
        misfit == Misfit::Wrong
    }

    fn misfit(&self, inner: Bracket, close: Bracket) -> Misfit {
        let Some((open, outer)) = self.open.split_last() else { return Misfit::Extra };
        let partners = || outer.iter().filter(|token| token.kind == Kind::Open(close));
        let is_first = self.next.is_first_on_line();
        // A closing bracket that begins a line stands below the line that it closes.
        if is_first && open.indent > self.next.indent && partners().any(|token| token.indent == self.next.indent) {
            return Misfit::Unclosed;
        }
        // One on a line with the open bracket, and with no other that it could close, is meant for it.
        let shares_line = open.line == self.next.line;
        if shares_line && partners().all(|token| token.line != self.next.line) {
            return Misfit::Wrong;
        }
        let has_partner = partners().next().is_some();
        match (self.balance.lacks(inner), self.balance.exceeds(close)) {
            (true, true) => Misfit::Wrong,
            (true, false) if has_partner => Misfit::Unclosed,
            (false, true) => Misfit::Extra,
            _ if shares_line => Misfit::Wrong,
            _ if has_partner && is_first => Misfit::Unclosed,
            _ => Misfit::Extra,
        }
    }

    /// Returns whether the innermost group must have ended before the next token, which is not a closing bracket.
    pub(super) fn is_left_open(&self, inner: Bracket) -> bool {
        let [.., outer, open] = self.open.as_slice() else { return false };
        let is_lacking = self.balance.lacks(inner);
        // An entry of an outer group begins a line that is indented no more than the line of the open bracket.
        let is_outside = self.next.is_first_on_line() && self.next.line > open.line && self.next.indent <= open.indent;
        let is_map_entry = self.next.kind == Kind::Text && self.second.kind == Kind::Colon;
        let is_next_entry = inner == Bracket::Round && outer.kind == Kind::Open(Bracket::Curly) && is_map_entry;
        is_lacking && is_outside || is_next_entry && (is_lacking || is_outside)
    }

    /// The opening bracket of the innermost group.
    fn open_location(&self) -> Location {
        self.token_location(self.open.last().unwrap_or(&self.next))
    }

    /// Reports all brackets that are open at the end of the file at once.
    pub(super) fn end_of_file(&mut self) {
        let is_reported = self.has_misfit || self.lossy_depth == self.open.len();
        self.lossy_depth = self.open.len();
        if is_reported || self.lexer.ends_in_comment {
            return;
        }
        self.has_misfit = true;
        let mut open = Vec::new();
        for token in &self.open {
            let bracket = if let Kind::Open(bracket) = token.kind { bracket } else { Bracket::Round };
            open.push((self.token_location(token), bracket));
        }
        if let Some(error) = syntax::unclosed_at_end(&open) {
            self.report(error);
        }
    }

    /// Skips what RON has no use for; whether there was any.
    pub(super) fn skip_stray(&mut self) -> bool {
        let has_stray = self.next.kind == Kind::Stray;
        while self.next.kind == Kind::Stray {
            self.unexpected(syntax::stray(&self.next_location(), self.next_text()));
        }
        has_stray
    }

    /// Reads the comma after an entry; false if it is missing. In any case the next token begins an entry or closes.
    pub(super) fn separator(&mut self, inner: Bracket) -> bool {
        let needs_no_comma = std::mem::take(&mut self.needs_no_comma);
        loop {
            let (location, found) = (self.next_location(), self.next_text());
            match self.next.kind {
                Kind::Comma => {
                    self.advance();
                    return true;
                }
                Kind::Close(_) | Kind::End => return true,
                Kind::Stray if found == ";" => {
                    self.unexpected(syntax::no_comma(&location, found));
                    return true;
                }
                Kind::Stray if found == "/" && self.text[..self.end].ends_with(|c: char| c.is_ascii_digit()) => {
                    self.report(syntax::division(&location));
                    self.skip(0);
                }
                Kind::Stray => self.unexpected(syntax::stray(&location, found)),
                Kind::Colon => {
                    self.report(syntax::second_colon(&location));
                    self.skip(0);
                }
                _ if needs_no_comma => return true,
                _ => {
                    // At the end of the entry before it, unless a bracket is what is missing.
                    if !self.is_left_open(inner) {
                        self.expected(syntax::missing_comma(&self.location(self.end, self.end), found));
                    }
                    return false;
                }
            }
        }
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
}
