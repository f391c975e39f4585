//! Limits of a file's text and tokens: what is nested too deeply must not reach a parser that recurses.

use super::{FILE_BYTES, FILE_TOKENS, Limit, NESTING, OPERATORS};
use crate::error::{ShaderError, position};
use crate::token::{Token, TokenKind};

/// Checks the size of a file.
pub(crate) fn check_size(file: &str, text: &str) -> Result<(), ShaderError> {
    match FILE_BYTES.exceeded(text.len()) {
        Some(message) => Err(ShaderError::new(file, position(text, FILE_BYTES.max), message)),
        None => Ok(()),
    }
}

/// Checks the number and the nesting of a file's tokens.
pub(crate) fn check_text(file: &str, text: &str, tokens: &[Token]) -> Result<(), ShaderError> {
    let last = (tokens.len() > FILE_TOKENS.max).then_some((FILE_TOKENS.max, FILE_TOKENS));
    match last.or_else(|| too_deep(text, tokens)) {
        Some((at, limit)) => {
            let message = limit.exceeded(limit.max + 1).expect("one more is too many");
            Err(ShaderError::new(file, position(text, tokens[at].start as usize), message))
        }
        None => Ok(()),
    }
}

/// The first token that is nested too deeply, and the limit that it exceeds.
fn too_deep(text: &str, tokens: &[Token]) -> Option<(usize, Limit)> {
    let mut depth = Depth::default();
    for (at, token) in tokens.iter().enumerate() {
        let is_else = tokens.get(at + 1).is_some_and(|next| next.of(text) == "else");
        let is_prefix = at == 0 || matches!(tokens[at - 1].kind, TokenKind::Sign(sign) if !matches!(sign, ')' | ']'));
        if let TokenKind::Sign(sign) = token.kind {
            depth.step(sign, is_prefix, is_else);
        }
        if depth.outer.nesting + depth.inner.nesting > NESTING.max {
            return Some((at, NESTING));
        }
        if depth.outer.operators + depth.inner.operators > OPERATORS.max {
            return Some((at, OPERATORS));
        }
    }
    None
}

/// Nesting of an expression, or of a chain of statements.
#[derive(Clone, Copy, Default)]
struct Level {
    /// The bracket that it is in, and the operators in front of what is read.
    nesting: usize,
    /// Its operators, calls and indices so far.
    operators: usize,
    /// The branches before this one, each of which is nested in the one before.
    branches: usize,
}

#[derive(Default)]
struct Depth {
    /// The levels around the brackets that are open.
    open: Vec<Level>,
    outer: Level,
    inner: Level,
}

impl Depth {
    fn step(&mut self, sign: char, is_prefix: bool, is_before_else: bool) {
        match sign {
            '(' | '[' => self.open(Level { nesting: self.inner.nesting + 1, ..self.inner }),
            // The condition or the signature before a block is not around it.
            '{' => self.open(Level { nesting: 1, operators: self.inner.branches, branches: self.inner.branches }),
            ')' | ']' => {
                let around = self.close();
                self.inner = Level { nesting: around.nesting.saturating_sub(1), ..around };
                self.inner.operators += 1;
            }
            '}' => {
                let around = self.close();
                // The next branch is nested in this one.
                let branches = if is_before_else { around.branches + 1 } else { 0 };
                self.inner = Level { branches, operators: branches, nesting: 0 };
            }
            ',' | ';' => self.inner = Level::default(),
            '@' | ':' => {}
            _ => {
                let is_prefix = is_prefix && matches!(sign, '-' | '!' | '~' | '&' | '*');
                self.inner.nesting = if is_prefix { self.inner.nesting + 1 } else { 0 };
                self.inner.operators += 1;
            }
        }
    }

    fn open(&mut self, around: Level) {
        self.outer.nesting += around.nesting;
        self.outer.operators += around.operators;
        self.open.push(around);
        self.inner = Level::default();
    }

    fn close(&mut self) -> Level {
        let around = self.open.pop().unwrap_or_default();
        self.outer.nesting -= around.nesting;
        self.outer.operators -= around.operators;
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::token::tokens;

    fn exceeded(body: &str) -> Option<&'static str> {
        let text = format!("fn f(x: f32) -> f32 {{ return {body}; }}");
        too_deep(&text, &tokens(&text).expect("no comment is open")).map(|(_, limit)| limit.counts)
    }

    #[test]
    fn brackets_and_prefix_operators_add_up() {
        let nested = |times: usize, open: &str, close: &str| {
            exceeded(&format!("{}x{}", open.repeat(times), close.repeat(times)))
        };
        for (open, close, most) in [("(", ")", 63), ("(- ", ")", 31), ("!", "", 64), ("-(", ")", 32), ("f(", ")", 63)] {
            assert_eq!(nested(most, open, close), None, "{open}");
            assert_eq!(nested(most + 1, open, close), Some(NESTING.counts), "{open}");
        }
    }

    #[test]
    fn operators_add_up_over_the_expressions_around() {
        assert_eq!(exceeded(&"x + ".repeat(256)), None);
        assert_eq!(exceeded(&"x + ".repeat(257)), Some(OPERATORS.counts));
        assert_eq!(exceeded(&format!("({}(x))", "x && ".repeat(130))), Some(OPERATORS.counts));
        assert_eq!(exceeded(&format!("{}f({}x)", "x + ".repeat(150), "x + ".repeat(150))), Some(OPERATORS.counts));
        assert_eq!(exceeded(&format!("x{}", ".x".repeat(257))), Some(OPERATORS.counts));
        assert_eq!(exceeded(&format!("f({}x)", "x + x, ".repeat(1000))), None);
        assert_eq!(exceeded(&format!("x;{}", "x += x * x;".repeat(1000))), None);
        assert_eq!(exceeded(&"f(x) ".repeat(256)), None);
        assert_eq!(exceeded(&"f(x) ".repeat(257)), Some(OPERATORS.counts), "a call is an operator");
        assert_eq!(exceeded(&"x: @a ".repeat(600)), None, "a type and an attribute are none");
    }

    /// At the first token that is too much, also where two levels add up.
    #[test]
    fn the_first_token_too_many_is_named() {
        let at = |text: &str| {
            let tokens = tokens(text).expect("no comment is open");
            too_deep(text, &tokens).map(|(at, limit)| (tokens[at].start as usize, limit.counts))
        };
        assert_eq!(at(&"(".repeat(65)), Some((64, NESTING.counts)));
        assert_eq!(at(&"-".repeat(65)), Some((64, NESTING.counts)));
        assert_eq!(at(&("x".to_owned() + &"+x".repeat(257))), Some((513, OPERATORS.counts)));
        assert_eq!(at(&format!("{0}({0}x)", "x+".repeat(150))), Some((514, OPERATORS.counts)));
        let (most, more) = ("x ".repeat(FILE_TOKENS.max), "x ".repeat(FILE_TOKENS.max + 1));
        assert!(check_text("f", &most, &tokens(&most).expect("tokens")).is_ok());
        assert!(check_text("f", &more, &tokens(&more).expect("tokens")).is_err());
        assert!(
            check_size("f", &"x".repeat(FILE_BYTES.max)).is_ok()
                && check_size("f", &"x".repeat(FILE_BYTES.max + 1)).is_err()
        );
    }

    #[test]
    fn branches_nest_and_statements_do_not() {
        assert_eq!(exceeded(&format!("x; if x {{ }} {}", "else if x { } ".repeat(257))), Some(OPERATORS.counts));
        assert_eq!(exceeded(&format!("x; {}", "if x { } else { } ".repeat(1000))), None);
    }
}
