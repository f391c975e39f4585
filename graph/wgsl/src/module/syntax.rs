//! The top level of a file: where each declaration starts and ends.

use std::ops::Range;

use afterimage_base::diagnostic::quote;

use super::import::{Imported, imported};
use super::kind::DeclarationKind;
use super::wrong::Wrong;
use crate::token::{Token, TokenKind};

/// A part of a file's top level, by the indices of its tokens.
pub(super) enum Item {
    Import(Vec<Imported>),
    Directive(Range<usize>),
    /// The kind, the tokens and the name.
    Declaration(DeclarationKind, Range<usize>, Option<usize>),
}

const IMPORT: &str = "write `import afterimage::color::luminance;` for the library, and `import super::name::item;` \
                      for a file beside this one";
const CONDITION: &str = "for what depends on a setting, branch on a parameter, or write two kinds";
const MACRO: &str = "write a `const` for a value, and a function for code";

/// Directives, words and attributes of other languages, and what is written in their place.
const DIRECTIVES: [(&str, &str); 9] = [
    ("import", IMPORT),
    ("include", IMPORT),
    ("define_import_path", "leave it out: a file is imported by its own name"),
    ("define", MACRO),
    ("undef", MACRO),
    ("if", CONDITION),
    ("ifdef", CONDITION),
    ("ifndef", CONDITION),
    ("else", CONDITION),
];
const WORDS: [(&str, &str); 2] = [("include", IMPORT), ("use", IMPORT)];
const ATTRIBUTES: [(&str, &str); 3] = [("if", CONDITION), ("elif", CONDITION), ("else", CONDITION)];

/// The first use of another language on top of WGSL: conditions of WESL, a preprocessor, imports of other frameworks.
fn other_language(text: &str, tokens: &[Token]) -> Option<Wrong> {
    let word = |at: usize| tokens.get(at).filter(|token| token.kind == TokenKind::Name).map_or("", |it| it.of(text));
    let mut depth = 0_usize;
    for (token, this) in tokens.iter().enumerate() {
        let next = word(token + 1);
        let is_first = token == 0 || matches!(tokens[token - 1].kind, TokenKind::Sign(';' | '}'));
        let (what, known): (_, &[_]) = match this.kind {
            TokenKind::Sign('#') => (format!("#{next}"), &DIRECTIVES),
            TokenKind::Sign('@') => (format!("@{next}"), &ATTRIBUTES),
            TokenKind::Name if depth == 0 && is_first => (word(token).to_owned(), &WORDS),
            TokenKind::Sign('{') => {
                depth += 1;
                continue;
            }
            TokenKind::Sign('}') => {
                depth = depth.saturating_sub(1);
                continue;
            }
            TokenKind::Name if depth > 0 && word(token) == "import" && !next.is_empty() => {
                return Some(misplaced(token));
            }
            _ => continue,
        };
        let found = known.iter().find(|(name, _)| what.trim_start_matches(['#', '@']) == *name);
        let help = found.map(|(_, help)| *help);
        if help.is_some() || what.starts_with('#') {
            return Some(Wrong { token, message: format!("{} is not WGSL", quote(&what)), help });
        }
    }
    None
}

fn misplaced(token: usize) -> Wrong {
    Wrong { token, message: "imports come first in a file, before directives and declarations".into(), help: None }
}

/// The parts of a file.
pub(super) fn items(text: &str, tokens: &[Token]) -> Result<Vec<Item>, Wrong> {
    if let Some(wrong) = other_language(text, tokens) {
        return Err(wrong);
    }
    let mut reader = Reader { text, tokens, at: 0 };
    let mut items = Vec::new();
    while reader.at < tokens.len() {
        let token = reader.at;
        match reader.item()? {
            Some(Item::Import(_)) if items.last().is_some_and(|item| !matches!(item, Item::Import(_))) => {
                return Err(misplaced(token));
            }
            item => items.extend(item),
        }
    }
    Ok(items)
}

struct Reader<'t> {
    text: &'t str,
    tokens: &'t [Token],
    at: usize,
}

/// End of a part of the top level.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Semicolon,
    /// With the bracket that closes its first `{`.
    Block,
    /// With whichever of the two comes first.
    Either,
}

impl Reader<'_> {
    fn item(&mut self) -> Result<Option<Item>, Wrong> {
        let start = self.at;
        if self.is_import() {
            let (items, length) = imported(self.text, &self.tokens[start..])
                .map_err(|wrong| Wrong { token: start + wrong.token, ..wrong })?;
            self.at += length;
            return Ok(Some(Item::Import(items)));
        }
        if self.tokens[start].is(';') {
            self.at += 1;
            return Ok(None);
        }
        self.attributes()?;
        let word = self.word();
        if start == self.at && matches!(word, "enable" | "requires" | "diagnostic") {
            self.skip(End::Semicolon)?;
            return Ok(Some(Item::Directive(start..self.at)));
        }
        let (kind, end) = match word {
            "fn" => (DeclarationKind::Function, End::Block),
            "struct" => (DeclarationKind::Struct, End::Block),
            "const" => (DeclarationKind::Constant, End::Semicolon),
            "override" => (DeclarationKind::Override, End::Semicolon),
            "alias" => (DeclarationKind::Alias, End::Semicolon),
            "var" => (DeclarationKind::Variable, End::Semicolon),
            "const_assert" => (DeclarationKind::Assertion, End::Semicolon),
            _ => (DeclarationKind::Unknown, End::Either),
        };
        let name = self.declared(kind);
        self.skip(end)?;
        Ok(Some(Item::Declaration(kind, start..self.at, name)))
    }

    /// True if an import starts here: no declaration, even a wrong one, has these two words in front.
    fn is_import(&self) -> bool {
        let is_path = |token: &Token| token.kind == TokenKind::Name || token.is('{');
        self.word() == "import" && self.tokens.get(self.at + 1).is_some_and(is_path)
    }

    /// The token here, if it is a word.
    fn word(&self) -> &str {
        let token = self.tokens.get(self.at).filter(|token| token.kind == TokenKind::Name);
        token.map_or("", |token| token.of(self.text))
    }

    fn attributes(&mut self) -> Result<(), Wrong> {
        while self.tokens.get(self.at).is_some_and(|token| token.is('@')) {
            self.at += 2;
            if self.tokens.get(self.at).is_some_and(|token| token.is('(')) {
                self.at = closing(self.text, self.tokens, self.at)? + 1;
            }
        }
        self.at = self.at.min(self.tokens.len());
        Ok(())
    }

    /// The name after the keyword here.
    fn declared(&self, kind: DeclarationKind) -> Option<usize> {
        if matches!(kind, DeclarationKind::Assertion | DeclarationKind::Unknown) {
            return None;
        }
        let mut at = self.at + 1;
        if self.tokens.get(at)?.is('<') {
            at += self.tokens[at..].iter().position(|token| token.is('>'))? + 1;
        }
        (self.tokens.get(at)?.kind == TokenKind::Name).then_some(at)
    }

    /// Goes on behind the end.
    fn skip(&mut self, end: End) -> Result<(), Wrong> {
        while let Some(token) = self.tokens.get(self.at) {
            match token.kind {
                TokenKind::Sign('(' | '[') => self.at = closing(self.text, self.tokens, self.at)?,
                TokenKind::Sign('{') => {
                    self.at = closing(self.text, self.tokens, self.at)?;
                    if end != End::Semicolon {
                        break;
                    }
                }
                TokenKind::Sign(';') if end != End::Block => break,
                _ => {}
            }
            self.at += 1;
        }
        self.at = (self.at + 1).min(self.tokens.len());
        Ok(())
    }
}

/// The index of the bracket that closes the one at `open`.
fn closing(text: &str, tokens: &[Token], open: usize) -> Result<usize, Wrong> {
    let mut stack = Vec::new();
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.kind {
            TokenKind::Sign('(' | '[' | '{') => stack.push(at),
            TokenKind::Sign(sign @ (')' | ']' | '}')) => {
                let last = stack.pop().expect("the first token opens a bracket");
                let opened = tokens[last].of(text);
                if !matches!((opened, sign), ("(", ')') | ("[", ']') | ("{", '}')) {
                    return Err(Wrong {
                        token: at,
                        message: format!("this `{sign}` does not close the `{opened}` before"),
                        help: None,
                    });
                }
                if stack.is_empty() {
                    return Ok(at);
                }
            }
            _ => {}
        }
    }
    let token = *stack.last().expect("the first token opens a bracket");
    Err(Wrong { token, message: format!("this `{}` is never closed", tokens[token].of(text)), help: None })
}
