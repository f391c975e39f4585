//! Import statements of WESL, as in `import super::steps::{step, ramp as slope};`.

use std::ops::Range;

use super::wrong::Wrong;
use crate::token::{Token, TokenKind};

/// An item that a file imports, or a path that stands in its code.
#[derive(Clone, Debug)]
pub(super) struct Imported {
    /// The bytes of each name of its path.
    pub(super) path: Vec<Range<u32>>,
    /// The bytes of its name in the file.
    pub(super) name: Range<u32>,
}

const FORM: &str =
    "an import is a path and a semicolon, as in `import afterimage::color::{luminance, brightest as top};`";
/// Names in a path: none of the framework needs more than three.
const MAX_PATH: usize = 8;

/// The items of the import statement that the tokens start with, and the number of its tokens.
pub(super) fn imported(text: &str, tokens: &[Token]) -> Result<(Vec<Imported>, usize), Wrong> {
    let mut reader = Reader { text, tokens, at: 1, found: Vec::new() };
    reader.tree(&[])?;
    if !reader.is(';') {
        return Err(reader.wrong());
    }
    Ok((reader.found, reader.at + 1))
}

/// The bytes of each name of a path that is one token.
pub(super) fn names(text: &str, token: &Token) -> Vec<Range<u32>> {
    let mut start = token.start;
    let range = move |name: &str| {
        let range = start..start + name.len() as u32;
        start = range.end + "::".len() as u32;
        range
    };
    token.of(text).split("::").map(range).collect()
}

struct Reader<'t> {
    text: &'t str,
    tokens: &'t [Token],
    at: usize,
    found: Vec<Imported>,
}

impl Reader<'_> {
    fn is(&self, sign: char) -> bool {
        self.tokens.get(self.at).is_some_and(|token| token.is(sign))
    }

    /// Goes behind the sign, if it is the next token.
    fn skip(&mut self, sign: char) -> bool {
        let is_next = self.is(sign);
        self.at += usize::from(is_next);
        is_next
    }

    fn wrong(&self) -> Wrong {
        Wrong { token: self.at.min(self.tokens.len() - 1), message: FORM.into(), help: None }
    }

    /// The token here, which must be a name or a path.
    fn name(&mut self) -> Result<Token, Wrong> {
        let token = self.tokens.get(self.at).copied().filter(|token| token.kind == TokenKind::Name);
        self.at += usize::from(token.is_some());
        token.ok_or_else(|| self.wrong())
    }

    /// A path with what it ends in: a name, or a list of paths in braces.
    fn tree(&mut self, before: &[Range<u32>]) -> Result<(), Wrong> {
        let mut path = before.to_vec();
        loop {
            if self.is('{') {
                break;
            }
            let token = self.name()?;
            path.extend(names(self.text, &token));
            if path.len() > MAX_PATH {
                self.at -= 1;
                let message = format!("a path has at most {MAX_PATH} names");
                return Err(Wrong { message, ..self.wrong() });
            }
            if !self.skip(':') {
                return self.item(path);
            }
            if !self.skip(':') {
                return Err(self.wrong());
            }
        }
        if path.len() == before.len() {
            return Err(self.wrong());
        }
        self.at += 1;
        loop {
            self.tree(&path)?;
            let is_more = self.skip(',');
            if self.skip('}') {
                return Ok(());
            }
            if !is_more {
                return Err(self.wrong());
            }
        }
    }

    fn item(&mut self, path: Vec<Range<u32>>) -> Result<(), Wrong> {
        let mut name = path.last().cloned().expect("the path has a name");
        if self.tokens.get(self.at).is_some_and(|token| token.of(self.text) == "as") {
            self.at += 1;
            let token = self.name()?;
            name = token.start..token.end;
            if names(self.text, &token).len() > 1 {
                self.at -= 1;
                return Err(self.wrong());
            }
        }
        self.found.push(Imported { path, name });
        Ok(())
    }
}
