//! Reads the conditions of nodes (`when`).
//!
//! ```text
//! condition  = both { "or" both }
//! both       = single { "and" single }
//! single     = "not" single | "(" condition ")" | "true" | "false" | fact | side compare side
//! side       = fact | number
//! compare    = "<" | "<=" | ">" | ">=" | "==" | "!="
//! ```

use std::ops::Range;
use std::sync::Arc;

use super::{Comparison, Condition, Expression, Side};
use crate::check::limits::MAX_CONDITION;
use afterimage_base::diagnostic::quote;

/// A condition that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionError {
    /// The bytes of the condition that are at fault.
    pub span: Range<usize>,
    /// The error.
    pub message: String,
    /// The help.
    pub help: String,
}

impl Condition {
    /// Reads a condition.
    ///
    /// # Errors
    /// The first error, with its bytes.
    pub fn parse(text: &str) -> Result<Self, ConditionError> {
        let tokens = tokens(text)?;
        let mut parser = Parser { text, tokens, next: 0, depth: 0 };
        let expression = parser.any()?;
        match parser.peek() {
            None => Ok(Self(Arc::new(expression))),
            Some(_) => Err(parser.expected("`and`, `or` or the end of the condition")),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Number(f64),
    Sign(&'static str),
}

const SIGNS: [&str; 8] = ["<=", ">=", "==", "!=", "<", ">", "(", ")"];

fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, ConditionError> {
    let mut all = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let (token, length) = if c.is_whitespace() {
            at += c.len_utf8();
            continue;
        } else if let Some(sign) = SIGNS.into_iter().find(|sign| rest.starts_with(sign)) {
            (Token::Sign(sign), sign.len())
        } else if c.is_alphabetic() || c == '_' {
            let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            (Token::Word(rest[..length].to_owned()), length)
        } else if c.is_ascii_digit() || "+-.".contains(c) {
            number(rest, at)?
        } else {
            return Err(strange(c, rest, at));
        };
        all.push((token, at..at + length));
        at += length;
    }
    Ok(all)
}

fn number(rest: &str, at: usize) -> Result<(Token, usize), ConditionError> {
    let mut length = 0;
    let mut before = ' ';
    for c in rest.chars() {
        let is_exponent_sign = "+-".contains(c) && "eE".contains(before);
        if !(c.is_ascii_alphanumeric() || c == '.' || is_exponent_sign || length == 0) {
            break;
        }
        before = c;
        length += c.len_utf8();
    }
    match rest[..length].parse() {
        Ok(number) if f64::is_finite(number) => Ok((Token::Number(number), length)),
        _ => Err(ConditionError {
            span: at..at + length,
            message: "this is not a number".into(),
            help: "write numbers as `10`, `-2.5` or `1e3`".into(),
        }),
    }
}

fn strange(c: char, rest: &str, at: usize) -> ConditionError {
    let (length, help) = match c {
        '&' => (rest.len() - rest.trim_start_matches('&').len(), "write `and`"),
        '|' => (rest.len() - rest.trim_start_matches('|').len(), "write `or`"),
        '!' => (1, "write `not`"),
        '=' => (1, "write `==`"),
        _ => (c.len_utf8(), "a condition looks like `emissive and illuminance < 10`"),
    };
    let message = format!("{} does not belong into a condition", quote(&rest[..length]));
    ConditionError { span: at..at + length, message, help: help.into() }
}

/// Brackets and `not`s within each other.
const MAX_DEPTH: usize = 64;
/// Words and signs in one condition.
const MAX_LENGTH: usize = 512;

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<(Token, Range<usize>)>,
    next: usize,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.next).map(|(token, _)| token)
    }

    fn take_word(&mut self, word: &str) -> bool {
        let is_it = matches!(self.peek(), Some(Token::Word(found)) if found == word);
        self.next += usize::from(is_it);
        is_it
    }

    fn take_sign(&mut self, sign: &str) -> bool {
        let is_it = matches!(self.peek(), Some(Token::Sign(found)) if *found == sign);
        self.next += usize::from(is_it);
        is_it
    }

    fn span(&self) -> Range<usize> {
        let end = self.text.len();
        self.tokens.get(self.next).map_or(end..end, |(_, span)| span.clone())
    }

    fn expected(&self, what: &str) -> ConditionError {
        let span = self.span();
        let found = match self.text.get(span.clone()) {
            Some("") | None => "the condition ends".into(),
            Some(text) => format!("there is {}", quote(text)),
        };
        let message = format!("expected {what}, but {found}");
        ConditionError { span, message, help: "a condition looks like `emissive and illuminance < 10`".into() }
    }

    fn any(&mut self) -> Result<Expression, ConditionError> {
        let mut left = self.all()?;
        while self.take_word("or") {
            left = Expression::Or(Box::new(left), Box::new(self.all()?));
        }
        Ok(left)
    }

    fn all(&mut self) -> Result<Expression, ConditionError> {
        let mut left = self.single()?;
        while self.take_word("and") {
            left = Expression::And(Arc::new(left), Arc::new(self.single()?));
        }
        Ok(left)
    }

    fn single(&mut self) -> Result<Expression, ConditionError> {
        if self.depth >= MAX_DEPTH || self.tokens.len() > MAX_LENGTH || self.text.len() > MAX_CONDITION {
            return Err(ConditionError {
                span: self.span(),
                message: "the condition is too long".into(),
                help: "let the host tell one fact in place of many".into(),
            });
        }
        self.depth += 1;
        let single = self.unguarded();
        self.depth -= 1;
        single
    }

    fn unguarded(&mut self) -> Result<Expression, ConditionError> {
        if self.take_word("not") {
            return Ok(Expression::Not(Box::new(self.single()?)));
        }
        if self.take_sign("(") {
            let inner = self.any()?;
            return if self.take_sign(")") { Ok(inner) } else { Err(self.expected("`)`")) };
        }
        for constant in [true, false] {
            if self.take_word(if constant { "true" } else { "false" }) {
                return Ok(Expression::Constant(constant));
            }
        }
        self.comparison()
    }

    fn comparison(&mut self) -> Result<Expression, ConditionError> {
        let left = self.side()?;
        let sign = match self.peek() {
            Some(Token::Sign(sign)) => Comparison::named(sign),
            _ => None,
        };
        match (left, sign) {
            (left, Some(comparison)) => {
                self.next += 1;
                self.refuse_flag(&left)?;
                Ok(Expression::Compare(left, comparison, self.side()?))
            }
            (Side::Fact(name), None) => Ok(Expression::Flag(name)),
            (Side::Number(_), None) => Err(self.expected("a comparison such as `<`")),
        }
    }

    fn refuse_flag(&self, left: &Side) -> Result<(), ConditionError> {
        let fact = if let Side::Fact(name) = left { name.as_str() } else { "emissive" };
        match self.peek() {
            Some(Token::Word(word)) if word == "true" || word == "false" => Err(ConditionError {
                span: self.span(),
                message: "only numbers are compared".into(),
                help: format!("write `{fact}` for what must be true and `not {fact}` for what must be false"),
            }),
            _ => Ok(()),
        }
    }

    fn side(&mut self) -> Result<Side, ConditionError> {
        const WORDS: [&str; 3] = ["and", "or", "not"];
        let side = match self.peek() {
            Some(Token::Word(word)) if !WORDS.contains(&word.as_str()) => Side::Fact(word.clone()),
            Some(Token::Number(number)) => Side::Number(*number),
            _ => return Err(self.expected("the name of a fact")),
        };
        self.next += 1;
        Ok(side)
    }
}
