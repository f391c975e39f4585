//! Recovery after brackets that do not fit.
//!
//! Such a bracket is missing, of the wrong kind, or one too many. Which of them is decided by the number of brackets in
//! the text ([`Balance`]) and by the lines on which they stand.

use super::balance::Balance;
use super::bracket::Bracket;
use super::syntax;
use super::token::{Kind, Token};
use super::tokens::Tokens;
use afterimage_base::diagnostic::Location;

/// A group whose end has not been read.
struct OpenGroup {
    bracket: Bracket,
    /// Its opening bracket; where that is missing, the token after it.
    start: Token,
    /// True if entries may have been lost to a bracket that is not closed.
    is_partial: bool,
}

impl OpenGroup {
    fn place(&self, tokens: &Tokens<'_>) -> (Location, Bracket) {
        (tokens.location_of(&self.start), self.bracket)
    }
}

/// Reason why a closing bracket does not fit the innermost group.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Misfit {
    /// It closes an outer group; the innermost one is not closed.
    Missing,
    /// It is meant to close the innermost group, and of the wrong kind.
    Wrong,
    /// It closes nothing.
    Extra,
}

/// The open groups, and the errors so far that explain later ones. Each method for an error reports it.
pub(super) struct Recovery {
    open: Vec<OpenGroup>,
    balance: Balance,
    /// True if any bracket was missing, wrong or extra.
    pub(super) has_misfit: bool,
    /// True if an error was reported where the next comma would stand, so that no other one is about that comma.
    pub(super) needs_no_comma: bool,
}

impl Recovery {
    pub(super) fn new(balance: Balance) -> Self {
        Self { open: Vec::new(), balance, has_misfit: false, needs_no_comma: false }
    }

    /// The number of open groups.
    pub(super) fn depth(&self) -> usize {
        self.open.len()
    }

    /// Begins a group.
    pub(super) fn open(&mut self, bracket: Bracket, start: Token) {
        self.open.push(OpenGroup { bracket, start, is_partial: false });
    }

    /// Ends the innermost group. Returns whether it may have lost entries.
    pub(super) fn close(&mut self) -> bool {
        self.open.pop().is_some_and(|group| group.is_partial)
    }

    /// Returns whether a field of `Kind(field: value)` follows in a map, without the parenthesis before it.
    pub(super) fn lacks_parenthesis(&self, tokens: &Tokens<'_>) -> bool {
        let is_in_map = self.open.last().is_some_and(|group| group.bracket == Bracket::Curly);
        is_in_map && tokens.are_next(Kind::Word, Kind::Colon) && self.balance.exceeds(Bracket::Round)
    }

    /// The parenthesis after the name of a kind is missing.
    pub(super) fn parenthesis_missing(&mut self, tokens: &mut Tokens<'_>, kind: &str) {
        tokens.report(syntax::no_parenthesis(&tokens.location(tokens.end, tokens.end), kind));
        self.balance.add(Bracket::Round, -1);
        self.has_misfit = true;
        self.needs_no_comma = true;
    }

    /// Returns whether the innermost group must have ended before the next token, which is not a closing bracket: two
    /// of three signs say so.
    pub(super) fn is_left_open(&self, tokens: &Tokens<'_>) -> bool {
        let [.., outer, inner] = self.open.as_slice() else { return false };
        let (start, next) = (&inner.start, &tokens.next);
        // An entry of an outer group begins a line that is indented no more than the line of the open bracket.
        let is_outside = next.is_first_on_line() && next.line > start.line && next.indent <= start.indent;
        let is_map_entry = inner.bracket == Bracket::Round
            && outer.bracket == Bracket::Curly
            && tokens.are_next(Kind::Text, Kind::Colon);
        let signs = [self.balance.lacks(inner.bracket), is_outside, is_map_entry];
        signs.into_iter().filter(|sign| *sign).count() >= 2
    }

    /// Explains the next token, a closing bracket of another kind than that of the innermost group.
    pub(super) fn misfit(&self, close: Bracket, next: &Token) -> Misfit {
        let Some((inner, outer)) = self.open.split_last() else { return Misfit::Extra };
        let start = &inner.start;
        let partners = || outer.iter().map(|group| &group.start).filter(|token| token.kind == Kind::Open(close));
        let is_first = next.is_first_on_line();
        // A closing bracket that begins a line stands below the line that it closes.
        if is_first && start.indent > next.indent && partners().any(|token| token.indent == next.indent) {
            return Misfit::Missing;
        }
        // One on a line with the open bracket, and with no other that it could close, is meant for it.
        let shares_line = start.line == next.line;
        if shares_line && partners().all(|token| token.line != next.line) {
            return Misfit::Wrong;
        }
        let has_partner = partners().next().is_some();
        match (self.balance.lacks(inner.bracket), self.balance.exceeds(close)) {
            (true, true) => Misfit::Wrong,
            (true, false) if has_partner => Misfit::Missing,
            (false, true) => Misfit::Extra,
            _ if shares_line => Misfit::Wrong,
            _ if has_partner && is_first => Misfit::Missing,
            _ => Misfit::Extra,
        }
    }

    /// The innermost group is not closed before the next token. Entries of outer groups may stand inside of it.
    pub(super) fn closing_missing(&mut self, tokens: &mut Tokens<'_>) {
        let (open, bracket) = self.innermost(tokens);
        tokens.report(syntax::unclosed(&open, bracket, &tokens.next_location()));
        self.balance.add(bracket, 1);
        self.lose_entries();
        self.has_misfit = true;
        self.needs_no_comma = true;
    }

    /// The next token closes the innermost group, and is of the wrong kind.
    pub(super) fn closing_wrong(&mut self, tokens: &mut Tokens<'_>, close: Bracket) {
        let (open, bracket) = self.innermost(tokens);
        tokens.unexpected(syntax::wrong_close(&open, bracket, &tokens.next_location(), close));
        self.closing_as(bracket, close);
        self.has_misfit = true;
    }

    /// The bracket `close` stands in place of that which closes `bracket`. Reports nothing.
    pub(super) fn closing_as(&mut self, bracket: Bracket, close: Bracket) {
        self.balance.add(close, -1);
        self.balance.add(bracket, 1);
    }

    /// The next token closes nothing.
    pub(super) fn closing_extra(&mut self, tokens: &mut Tokens<'_>, close: Bracket) {
        let (open, bracket) = self.innermost(tokens);
        tokens.unexpected(syntax::extra_close(&open, bracket, &tokens.next_location(), close));
        self.balance.add(close, -1);
        self.has_misfit = true;
        self.needs_no_comma = true;
    }

    /// The text ends within groups. All of them are reported at once, unless an earlier error explains it.
    pub(super) fn end_of_text(&mut self, tokens: &mut Tokens<'_>) {
        self.lose_entries();
        if self.has_misfit || tokens.lexer.ends_in_comment {
            return;
        }
        self.has_misfit = true;
        let open: Vec<(Location, Bracket)> = self.open.iter().map(|group| group.place(tokens)).collect();
        if let Some(error) = syntax::unclosed_at_end(&open) {
            tokens.report(error);
        }
    }

    fn lose_entries(&mut self) {
        self.open.iter_mut().for_each(|group| group.is_partial = true);
    }

    fn innermost(&self, tokens: &Tokens<'_>) -> (Location, Bracket) {
        self.open.last().expect("a closing bracket is expected within groups only").place(tokens)
    }
}
