//! From tokens to a tree, past errors.
//!
//! After an error the parser continues at the next comma or closing bracket, so that every error of a file is reported
//! and none twice. A file without errors is read once. A file with errors is read again with the [`Balance`] of its
//! brackets, from which [`Recovery`] tells a missing bracket from one too many.

use std::sync::Arc;

use super::balance::Balance;
use super::bracket::Bracket;
use super::literal::{number, plain_name, plain_word, text};
use super::quotes::is_foreign_quote;
use super::recover::{Misfit, Recovery};
use super::shape::{Entry, list, map, struct_or_tuple};
use super::syntax;
use super::token::{Kind, Lexer, Token};
use super::tokens::Tokens;
use super::tree::{Group, Item, Tree};
use afterimage_base::diagnostic::{Diagnostic, Spanned};

/// Brackets within brackets; a pipeline needs about five.
const MAX_DEPTH: usize = 32;

/// The tree of a file and its syntax errors; where there are some, parts of the tree are broken.
pub(crate) struct Parsed {
    pub(crate) tree: Item,
    pub(crate) errors: Vec<Diagnostic>,
}

pub(crate) fn read(file: &Arc<str>, text: &str) -> Parsed {
    let parsed = Parser::new(file, text, Balance::default()).parse();
    if parsed.errors.is_empty() {
        return parsed;
    }
    Parser::new(file, text, Balance::of(file, text)).parse()
}

/// Returns whether there is nothing but space and comments.
pub(super) fn is_blank(file: &Arc<str>, text: &str) -> bool {
    let mut lexer = Lexer::new(file, text);
    lexer.next().kind == Kind::End && lexer.errors.is_empty()
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    recovery: Recovery,
}

impl<'a> Parser<'a> {
    fn new(file: &'a Arc<str>, text: &'a str, balance: Balance) -> Self {
        Self { tokens: Tokens::new(file, text), recovery: Recovery::new(balance) }
    }

    fn parse(mut self) -> Parsed {
        let tree = self.item();
        let tokens = &mut self.tokens;
        if tokens.next.kind != Kind::End && !self.recovery.has_misfit && !tree.value.is_broken() {
            let name = match &tree.value {
                Tree::Struct(Some(name), _) | Tree::Tuple(Some(name), _) => Some(name.value.as_str()),
                _ => None,
            };
            tokens.report(syntax::after_the_end(&tokens.next_location(), tokens.next_text(), name));
        }
        Parsed { tree, errors: self.tokens.lexer.errors.into_list() }
    }

    /// Reports that something is missing before the next token. The parser continues as if it were there.
    fn expected(&mut self, error: Diagnostic) {
        self.tokens.report(error);
        self.recovery.needs_no_comma = true;
    }

    /// A value; broken, with nothing read, if none begins here.
    fn item(&mut self) -> Item {
        let has_stray = self.tokens.skip_stray();
        let token = self.tokens.next;
        if !token.begins_value() {
            // At the end of the file, brackets that are open are what is reported.
            if !has_stray && (token.kind != Kind::End || self.recovery.depth() == 0) {
                self.expected(syntax::no_value(&self.tokens.next_location(), self.tokens.next_text()));
            }
            return Spanned::new(Tree::Broken, self.tokens.location(token.start, token.start));
        }
        self.tokens.advance();
        let tree = match token.kind {
            Kind::Word => self.word(&token),
            Kind::Number => self.number(&token),
            Kind::Text => self.quoted(&token),
            Kind::Open(bracket) => self.group(token, bracket, None),
            Kind::ForeignText => Tree::Text(self.tokens.text_of(&token).trim_matches(is_foreign_quote).to_owned()),
            Kind::BrokenText => Tree::Broken,
            _ => Tree::Other,
        };
        Spanned::new(tree, self.tokens.location(token.start, self.tokens.end))
    }

    /// A word, and what follows it in parentheses.
    fn word(&mut self, token: &Token) -> Tree {
        let (written, location) = (self.tokens.text_of(token), self.tokens.location_of(token));
        let next = self.tokens.next;
        let name = plain_name(written);
        if next.kind == Kind::Open(Bracket::Round) {
            if !matches!(plain_word(written), Tree::Name(_)) {
                self.tokens.report(syntax::value_with_parenthesis(&location, name));
            }
            self.tokens.advance();
        } else if self.recovery.lacks_parenthesis(&self.tokens) {
            self.recovery.parenthesis_missing(&mut self.tokens, name);
        } else {
            return plain_word(written);
        }
        self.group(next, Bracket::Round, Some(Spanned::new(name.to_owned(), location)))
    }

    fn number(&mut self, token: &Token) -> Tree {
        let written = self.tokens.text_of(token);
        number(written).unwrap_or_else(|| {
            let location = self.tokens.location_of(token);
            if !self.tokens.is_reported(&location) {
                self.tokens.report(syntax::bad_number(&location, written));
            }
            Tree::Broken
        })
    }

    fn quoted(&mut self, token: &Token) -> Tree {
        text(self.tokens.text_of(token)).unwrap_or_else(|| {
            self.tokens.report(syntax::bad_escape(&self.tokens.location_of(token)));
            Tree::Broken
        })
    }

    /// The entries up to the bracket that closes `open`, as a tree.
    fn group(&mut self, open: Token, bracket: Bracket, name: Option<Spanned<String>>) -> Tree {
        let location = self.tokens.location_of(&open);
        if self.recovery.depth() >= MAX_DEPTH {
            self.tokens.report(syntax::too_deep(&location));
            self.tokens.skip(1);
            return Tree::Broken;
        }
        self.recovery.open(bracket, open);
        let mut group = Group::default();
        let mut follows_error = false;
        while !self.eat_end(bracket, group.entries.last()) {
            match self.entry(bracket, follows_error) {
                Some(entry) => group.entries.push(entry),
                None => group.is_partial = true,
            }
            follows_error = !self.separator();
        }
        group.is_partial |= self.recovery.close();
        match bracket {
            Bracket::Round => struct_or_tuple(name, group, &mut self.tokens),
            Bracket::Square => list(&location, group, &mut self.tokens),
            Bracket::Curly => map(group),
        }
    }

    /// Returns whether the innermost group ends here. Its closing bracket is read, or reported as missing; closing
    /// brackets that close nothing are reported and skipped.
    fn eat_end(&mut self, bracket: Bracket, last: Option<&Entry>) -> bool {
        self.recovery.needs_no_comma = false;
        loop {
            let Self { tokens, recovery } = self;
            match tokens.next.kind {
                Kind::End => recovery.end_of_text(tokens),
                Kind::Close(close) if close == bracket => tokens.advance(),
                // A list with names should be a map. Its names are what is reported.
                Kind::Close(Bracket::Curly)
                    if bracket == Bracket::Square && last.is_some_and(|entry| entry.key.is_some()) =>
                {
                    recovery.closing_as(bracket, Bracket::Curly);
                    tokens.advance();
                }
                Kind::Close(close) => match recovery.misfit(close, &tokens.next) {
                    Misfit::Missing => recovery.closing_missing(tokens),
                    Misfit::Wrong => recovery.closing_wrong(tokens, close),
                    Misfit::Extra => {
                        recovery.closing_extra(tokens, close);
                        self.separator();
                        continue;
                    }
                },
                _ if recovery.is_left_open(tokens) => recovery.closing_missing(tokens),
                _ => return false,
            }
            return true;
        }
    }

    /// An entry; `None` where none can be read.
    fn entry(&mut self, bracket: Bracket, follows_error: bool) -> Option<Entry> {
        if self.tokens.next.kind == Kind::Comma {
            self.expected(syntax::no_entry(&self.tokens.next_location(), self.tokens.next_text()));
            return None;
        }
        let first = self.item();
        if self.eat_colon(bracket, &first) {
            let value = self.item();
            return (!first.value.is_broken()).then_some(Entry { key: Some(first), value, follows_error });
        }
        if bracket == Bracket::Curly {
            return None;
        }
        Some(Entry { key: None, value: first, follows_error })
    }

    /// Returns whether a value follows its key `first`; the colon is read, or reported as missing.
    fn eat_colon(&mut self, bracket: Bracket, first: &Item) -> bool {
        let is_key = match (self.tokens.next.kind, bracket) {
            (Kind::Colon, _) => {
                self.tokens.advance();
                return true;
            }
            (Kind::End, _) => false,
            // The opening quote of the key is missing: its closing one begins a string that is not closed.
            (Kind::BrokenText, _) => {
                self.recovery.needs_no_comma = true;
                false
            }
            (_, Bracket::Curly) => !first.value.is_broken(),
            (_, Bracket::Round) => matches!(first.value, Tree::Name(_)) && self.may_follow_colon(),
            (_, Bracket::Square) => false,
        };
        if !is_key {
            return false;
        }
        self.expected(syntax::no_colon(&self.tokens.next_location(), self.tokens.next_text()));
        while self.tokens.next.kind == Kind::Stray {
            self.tokens.advance();
        }
        // What has a colon of its own is the next entry.
        self.tokens.next.begins_value() && self.tokens.second.kind != Kind::Colon
    }

    /// Returns whether the next token is what a field's value begins with, or stands in place of the colon before it.
    fn may_follow_colon(&self) -> bool {
        match self.tokens.next.kind {
            Kind::Stray => self.tokens.next_text() != ";",
            Kind::Number | Kind::Text | Kind::Word => self.tokens.second.kind != Kind::Colon,
            _ => false,
        }
    }

    /// Reads the comma after an entry; false if it is missing. In any case the next token begins an entry or closes.
    fn separator(&mut self) -> bool {
        let is_digit = |c: char| c.is_ascii_digit();
        let needs_no_comma = std::mem::take(&mut self.recovery.needs_no_comma);
        let tokens = &mut self.tokens;
        loop {
            let (location, found) = (tokens.next_location(), tokens.next_text());
            match tokens.next.kind {
                Kind::Comma => {
                    tokens.advance();
                    return true;
                }
                Kind::Close(_) | Kind::End => return true,
                Kind::Stray if found == ";" => {
                    tokens.unexpected(syntax::no_comma(&location, found));
                    return true;
                }
                Kind::Stray if found == "/" && tokens.lexer.text[..tokens.end].ends_with(is_digit) => {
                    tokens.report(syntax::division(&location));
                    tokens.skip(0);
                }
                Kind::Stray => tokens.unexpected(syntax::stray(&location, found)),
                Kind::Colon => {
                    tokens.report(syntax::second_colon(&location));
                    tokens.skip(0);
                }
                _ if needs_no_comma => return true,
                // The bracket before it is what is missing.
                _ if self.recovery.is_left_open(tokens) => return false,
                _ => {
                    tokens.report(syntax::missing_comma(&tokens.location(tokens.end, tokens.end), found));
                    return false;
                }
            }
        }
    }
}
