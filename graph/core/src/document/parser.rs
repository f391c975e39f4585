//! From tokens to a tree, past errors.
//!
//! After an error the parser continues at the next comma or closing bracket, so that every error of a file is reported
//! and none twice. A file without errors is read once. A file with errors is read again with the [`Balance`] of its
//! brackets, which distinguishes a missing bracket from one too many.

use std::sync::Arc;

use super::balance::Balance;
use super::bracket::Bracket;
use super::quotes::is_foreign_quote;
use super::syntax;
use super::token::{Kind, Lexer, Token};
use super::tree::{Group, Item, Tree};
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned};

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

/// An entry of a group: `value` or `key: value`.
pub(super) struct Entry {
    pub(super) key: Option<Item>,
    pub(super) value: Item,
    /// True if it may be a part of the entry before it.
    pub(super) follows_error: bool,
}

pub(super) struct Parser<'a> {
    file: &'a Arc<str>,
    pub(super) text: &'a str,
    pub(super) lexer: Lexer<'a>,
    pub(super) next: Token,
    pub(super) second: Token,
    /// The end of the token before `next`.
    pub(super) end: usize,
    pub(super) open: Vec<Token>,
    /// How many of the open groups, the outermost first, may have lost entries to a bracket that is not closed.
    pub(super) lossy_depth: usize,
    pub(super) balance: Balance,
    /// True if what was read last may be followed by an entry without a comma, since an error was reported there.
    pub(super) needs_no_comma: bool,
    /// True if any bracket was missing or too many.
    pub(super) has_misfit: bool,
}

impl<'a> Parser<'a> {
    fn new(file: &'a Arc<str>, text: &'a str, balance: Balance) -> Self {
        let mut lexer = Lexer::new(file, text);
        let (next, second) = (lexer.next(), lexer.next());
        Self {
            file,
            text,
            lexer,
            next,
            second,
            end: 0,
            open: Vec::new(),
            lossy_depth: 0,
            balance,
            needs_no_comma: false,
            has_misfit: false,
        }
    }

    fn parse(mut self) -> Parsed {
        let tree = self.item();
        if self.next.kind != Kind::End && !self.has_misfit && !tree.value.is_broken() {
            let name = match &tree.value {
                Tree::Struct(Some(name), _) | Tree::Tuple(Some(name), _) => Some(name.value.as_str()),
                _ => None,
            };
            self.report(syntax::after_the_end(&self.next_location(), self.next_text(), name));
        }
        Parsed { tree, errors: self.lexer.errors.into_list() }
    }

    pub(super) fn advance(&mut self) {
        self.end = self.next.end;
        self.next = std::mem::replace(&mut self.second, self.lexer.next());
    }

    pub(super) fn report(&mut self, error: Diagnostic) {
        self.lexer.errors.push(error);
    }

    pub(super) fn location(&self, start: usize, end: usize) -> Location {
        Location::new(self.file, start..end)
    }

    pub(super) fn token_location(&self, token: &Token) -> Location {
        self.location(token.start, token.end)
    }

    pub(super) fn next_location(&self) -> Location {
        self.token_location(&self.next)
    }

    pub(super) fn text_of(&self, token: &Token) -> &'a str {
        &self.text[token.start..token.end]
    }

    /// The next token as it is written; empty at the end of the file.
    pub(super) fn next_text(&self) -> &'a str {
        self.text_of(&self.next)
    }

    /// A value; broken, with nothing read, if none begins here.
    fn item(&mut self) -> Item {
        let has_stray = self.skip_stray();
        let token = self.next;
        if !token.begins_value() {
            // At the end of the file, brackets that are open are what is reported.
            if !has_stray && (token.kind != Kind::End || self.open.is_empty()) {
                self.expected(syntax::no_value(&self.next_location(), self.next_text()));
            }
            return Spanned::new(Tree::Broken, self.location(token.start, token.start));
        }
        self.advance();
        let tree = match token.kind {
            Kind::Word => self.word(&token),
            Kind::Number => self.number(&token),
            Kind::Text => self.quoted(&token),
            Kind::Open(bracket) => self.group(token, bracket, None),
            Kind::ForeignText => Tree::Text(self.text_of(&token).trim_matches(is_foreign_quote).to_owned()),
            Kind::BrokenText => Tree::Broken,
            _ => Tree::Other,
        };
        Spanned::new(tree, self.location(token.start, self.end))
    }

    /// A word, and what follows it in parentheses.
    fn word(&mut self, token: &Token) -> Tree {
        let open = self.next;
        let is_open = open.kind == Kind::Open(Bracket::Round);
        if !is_open && !self.lacks_parenthesis() {
            return plain_word(self.text_of(token));
        }
        let name = Spanned::new(plain_name(self.text_of(token)).to_owned(), self.token_location(token));
        if is_open {
            if !matches!(plain_word(self.text_of(token)), Tree::Name(_)) {
                self.report(syntax::value_with_parenthesis(&self.token_location(token), &name.value));
            }
            self.advance();
        } else {
            self.expected(syntax::no_parenthesis(&self.location(self.end, self.end), &name.value));
            self.balance.add(Bracket::Round, -1);
            self.has_misfit = true;
        }
        self.group(open, Bracket::Round, Some(name))
    }

    /// Returns whether a field of `Kind(field: value)` follows in a map, without the parenthesis before it.
    fn lacks_parenthesis(&self) -> bool {
        let is_in_map = self.open.last().is_some_and(|open| open.kind == Kind::Open(Bracket::Curly));
        let is_field = self.next.kind == Kind::Word && self.second.kind == Kind::Colon;
        is_in_map && is_field && self.balance.exceeds(Bracket::Round)
    }

    fn number(&mut self, token: &Token) -> Tree {
        number(self.text_of(token)).unwrap_or_else(|| {
            let location = self.token_location(token);
            let last = self.lexer.errors.last().and_then(|error| error.labels.first());
            if last.is_none_or(|label| label.location != location) {
                self.report(syntax::bad_number(&location, self.text_of(token)));
            }
            Tree::Broken
        })
    }

    fn quoted(&mut self, token: &Token) -> Tree {
        text(self.text_of(token)).unwrap_or_else(|| {
            self.report(syntax::bad_escape(&self.token_location(token)));
            Tree::Broken
        })
    }

    /// The entries up to the bracket that closes `open`, as a tree.
    fn group(&mut self, open: Token, bracket: Bracket, name: Option<Spanned<String>>) -> Tree {
        if self.open.len() >= MAX_DEPTH {
            self.report(syntax::too_deep(&self.token_location(&open)));
            self.skip(1);
            return Tree::Broken;
        }
        self.open.push(open);
        let mut entries = Vec::new();
        let mut follows_error = false;
        let mut is_partial = false;
        while !self.eat_end(bracket, entries.last()) {
            match self.entry(bracket, follows_error) {
                Some(entry) => entries.push(entry),
                None => is_partial = true,
            }
            follows_error = !self.separator(bracket);
        }
        self.open.pop();
        let is_partial = is_partial || self.lossy_depth > self.open.len();
        self.lossy_depth = self.lossy_depth.min(self.open.len());
        match bracket {
            Bracket::Round => self.struct_or_tuple(name, Group { entries, is_partial }),
            Bracket::Square => self.list(&open, Group { entries, is_partial }),
            Bracket::Curly => Self::map(Group { entries, is_partial }),
        }
    }

    /// Returns whether the innermost group ends here. Its closing bracket is read, or reported as missing; closing
    /// brackets that close nothing are reported and skipped.
    fn eat_end(&mut self, bracket: Bracket, last: Option<&Entry>) -> bool {
        self.needs_no_comma = false;
        loop {
            match self.next.kind {
                Kind::End => self.end_of_file(),
                Kind::Close(close) if close == bracket => self.advance(),
                Kind::Close(close) => {
                    if !self.unexpected_close(bracket, close, last.is_some_and(|entry| entry.key.is_some())) {
                        self.needs_no_comma = true;
                        self.separator(bracket);
                        continue;
                    }
                }
                _ if self.is_left_open(bracket) => self.expected_close(bracket),
                _ => return false,
            }
            return true;
        }
    }

    /// An entry; `None` where none can be read.
    fn entry(&mut self, bracket: Bracket, follows_error: bool) -> Option<Entry> {
        if self.next.kind == Kind::Comma {
            self.expected(syntax::no_entry(&self.next_location(), self.next_text()));
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
        if self.next.kind == Kind::Colon {
            self.advance();
            return true;
        }
        let is_key = match bracket {
            // The opening quote of the key is missing: its closing one begins a string that is not closed.
            _ if self.next.kind == Kind::BrokenText => {
                self.needs_no_comma = true;
                false
            }
            Bracket::Curly => !first.value.is_broken(),
            Bracket::Round => matches!(first.value, Tree::Name(_)) && self.may_follow_colon(),
            Bracket::Square => false,
        };
        if !is_key || self.next.kind == Kind::End {
            return false;
        }
        self.expected(syntax::no_colon(&self.next_location(), self.next_text()));
        while self.next.kind == Kind::Stray {
            self.advance();
        }
        // What has a colon of its own is the next entry.
        self.next.begins_value() && self.second.kind != Kind::Colon
    }

    /// Returns whether the next token is what a field's value begins with, or stands in place of the colon before it.
    fn may_follow_colon(&self) -> bool {
        match self.next.kind {
            Kind::Stray => self.next_text() != ";",
            Kind::Number | Kind::Text | Kind::Word => self.second.kind != Kind::Colon,
            _ => false,
        }
    }
}

/// The value of a word without parentheses.
fn plain_word(word: &str) -> Tree {
    match word {
        "true" | "false" => Tree::Bool(word == "true"),
        "inf" | "inff32" | "inff64" => Tree::Float(f64::INFINITY),
        "NaN" | "NaNf32" | "NaNf64" => Tree::Float(f64::NAN),
        _ => Tree::Name(plain_name(word).to_owned()),
    }
}

/// Decodes a number; `None` if it is none that RON knows.
fn number(written: &str) -> Option<Tree> {
    plain_number(written).or_else(|| match ron::from_str::<i64>(written) {
        Ok(whole) => Some(Tree::Int(whole)),
        Err(_) => ron::from_str::<f64>(written).ok().map(Tree::Float),
    })
}

/// Decodes a string with its quotes; `None` if it has an unknown escape.
fn text(written: &str) -> Option<Tree> {
    match plain_text(written) {
        Some(plain) => Some(Tree::Text(plain.to_owned())),
        None => ron::from_str(written).ok().map(Tree::Text),
    }
}

/// A name without the `r#` of a raw one.
fn plain_name(word: &str) -> &str {
    word.strip_prefix("r#").unwrap_or(word)
}

/// Text between the quotes, if it needs no decoding.
fn plain_text(written: &str) -> Option<&str> {
    let inside = written.strip_prefix('"')?.strip_suffix('"')?;
    (!inside.contains(['\\', '"'])).then_some(inside)
}

/// A plain decimal number: digits, and perhaps a sign and a point. `ron` is slower.
fn plain_number(written: &str) -> Option<Tree> {
    let digits = written.strip_prefix('-').unwrap_or(written);
    let are_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    match digits.split_once('.') {
        Some((whole, rest)) if are_digits(whole) && are_digits(rest) => written.parse().ok().map(Tree::Float),
        None if are_digits(digits) && !digits.starts_with('0') => written.parse().ok().map(Tree::Int),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Tree, number, plain_number, plain_text};

    /// The fast path agrees with `ron`.
    #[test]
    fn plain_numbers_and_texts_are_those_of_ron() {
        let digits = ["0", "-0", "7", "-7", "007", "1_000", "0x1F", "+3", "9223372036854775807", "9223372036854775808"];
        let floats =
            ["1.5", "-0.0", "0.1", "00.5", ".5", "5.", "1e3", "1.5e-3", "1.0.0", "123456789.123456789123456789"];
        let mut taken = 0;
        for text in digits.into_iter().chain(floats) {
            let Some(plain) = plain_number(text) else { continue };
            let whole = ron::from_str::<i64>(text).ok().map(Tree::Int);
            let read = whole.or_else(|| ron::from_str::<f64>(text).ok().map(Tree::Float));
            assert_eq!(Some(&plain), read.as_ref(), "{text}");
            assert_eq!(Some(plain), number(text), "{text}");
            taken += 1;
        }
        assert!(taken >= 8, "only {taken} numbers are plain");
        for text in ["\"\"", "\"a b\"", "\"ü\n\"", "\"a\\tb\"", "\"\\\"\"", "\"/* no comment */\""] {
            let plain = plain_text(text).map(str::to_owned);
            assert!(plain.is_none_or(|plain| Ok(plain) == ron::from_str::<String>(text)), "{text}");
        }
    }
}
