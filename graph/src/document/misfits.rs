//! Brackets that do not fit each other.

use super::balance::{Misfit, is_outside};
use super::bracket::Bracket;
use super::parser::Parser;
use super::syntax;
use super::token::{Kind, Token};
use afterimage_base::diagnostic::Location;

impl Parser<'_> {
    /// Whether the closing bracket of the innermost group is missing before the next token.
    pub(super) fn is_left_open(&self, bracket: Bracket) -> bool {
        let [.., outer, open] = self.open.as_slice() else { return false };
        let is_outside = is_outside(open, &self.next);
        let is_lacking = self.balance.lacks(bracket);
        let is_map_entry = self.next.kind == Kind::Text && self.second.kind == Kind::Colon;
        let is_next_entry = bracket == Bracket::Round && outer.kind == Kind::Open(Bracket::Curly) && is_map_entry;
        is_lacking && is_outside || is_next_entry && (is_lacking || is_outside)
    }

    /// Reads a closing bracket of another kind, unless it closes an outer group.
    pub(super) fn misfit(&mut self, inner: Bracket, close: Bracket, has_names: bool) -> Misfit {
        let is_meant_as_map = inner == Bracket::Square && close == Bracket::Curly && has_names;
        let misfit = match is_meant_as_map {
            true => Misfit::Wrong,
            false => self.balance.misfit(&self.open, inner, (&self.next, close)),
        };
        if misfit == Misfit::Unclosed {
            self.unclosed(inner);
            return misfit;
        }
        // Names in a list are reported by themselves.
        if !is_meant_as_map {
            let (open, next) = (self.open_location(), self.next_location());
            let wording = if misfit == Misfit::Wrong { syntax::wrong_close } else { syntax::extra_close };
            self.report(wording((&open, inner), (&next, close)));
            self.has_misfit = true;
        }
        if misfit == Misfit::Wrong {
            self.balance.found_missing(inner);
        }
        self.balance.found_extra(close);
        self.advance();
        misfit
    }

    /// The opening bracket of the innermost group.
    fn open_location(&self) -> Location {
        self.token_location(self.open.last().unwrap_or(&self.next))
    }

    /// Ends the innermost group before the next token; what should follow outside may stand inside of it.
    pub(super) fn unclosed(&mut self, inner: Bracket) {
        self.report(syntax::unclosed((&self.open_location(), inner), &self.next_location()));
        self.balance.found_missing(inner);
        self.lossy = self.open.len();
        self.has_misfit = true;
        self.needs_no_comma = true;
    }

    /// Reports all brackets that are open at the end of the file at once.
    pub(super) fn end_of_file(&mut self) {
        let is_told = self.lossy == self.open.len();
        self.lossy = self.open.len();
        if is_told || self.has_misfit || self.lexer.ends_in_comment {
            return;
        }
        self.has_misfit = true;
        let bracket = |token: &Token| match token.kind {
            Kind::Open(bracket) => bracket,
            _ => Bracket::Round,
        };
        let open: Vec<_> = self.open.iter().map(|token| (self.token_location(token), bracket(token))).collect();
        if let Some(error) = syntax::unclosed_at_end(&open) {
            self.report(error);
        }
    }
}
