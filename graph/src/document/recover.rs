//! Recovery after errors: brackets that do not fit each other, missing commas, characters that do not belong there.

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

    /// Reports and skips what RON has no use for; whether there was any.
    pub(super) fn skip_stray(&mut self) -> bool {
        let has_stray = self.next.kind == Kind::Stray;
        while self.next.kind == Kind::Stray {
            self.report(syntax::stray(&self.next_location(), self.found()));
            self.advance();
        }
        has_stray
    }

    /// Reads the comma after an entry; false if it is missing. In any case the next token begins an entry or closes.
    pub(super) fn separator(&mut self, bracket: Bracket) -> bool {
        let needs_no_comma = std::mem::take(&mut self.needs_no_comma);
        loop {
            match self.next.kind {
                Kind::Comma => {
                    self.advance();
                    return true;
                }
                Kind::Close(_) | Kind::End => return true,
                Kind::Stray if self.found() == ";" => {
                    self.report(syntax::no_comma(&self.next_location(), self.found()));
                    self.advance();
                    return true;
                }
                Kind::Stray => self.stray(),
                Kind::Colon => {
                    self.report(syntax::second_colon(&self.next_location()));
                    self.skip(0);
                }
                _ if needs_no_comma => return true,
                _ => {
                    self.missing_comma(bracket);
                    return false;
                }
            }
        }
    }

    fn stray(&mut self) {
        let is_division = self.found() == "/" && self.text[..self.end].ends_with(|c: char| c.is_ascii_digit());
        if is_division {
            self.report(syntax::division(&self.next_location()));
            return self.skip(0);
        }
        self.report(syntax::stray(&self.next_location(), self.found()));
        self.advance();
    }

    /// Reports the comma at the end of the entry before it, unless a bracket is what is missing.
    fn missing_comma(&mut self, bracket: Bracket) {
        if !self.is_left_open(bracket) {
            self.report(syntax::missing_comma(&self.location(self.end, self.end), self.found()));
        }
    }

    /// Skips to the next comma or closing bracket outside of `depth` brackets, or past the one that ends them.
    pub(super) fn skip(&mut self, mut depth: usize) {
        let is_inside = depth > 0;
        loop {
            match self.next.kind {
                Kind::End => return,
                Kind::Comma if depth == 0 => return,
                Kind::Close(_) if depth == 0 => return,
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
