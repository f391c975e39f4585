//! Conditions over facts: `when: "emissive and illuminance < 10"`.
//!
//! ```text
//! condition  = both { "or" both }
//! both       = single { "and" single }
//! single     = "not" single | "(" condition ")" | "true" | "false" | fact | side compare side
//! side       = fact | number
//! compare    = "<" | "<=" | ">" | ">=" | "==" | "!="
//! ```
//!
//! A fact that the host does not tell may be either way, so a condition that depends on it holds: work is only left out when it is known
//! to be unneeded.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

/// What the host says of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fact {
    /// Something is so or not.
    Flag(bool),
    /// Something has this amount.
    Number(f64),
}

impl Fact {
    /// The fact in a text: `true`, `false` or a number.
    pub fn parse(text: &str) -> Option<Self> {
        match text.trim() {
            "true" => Some(Self::Flag(true)),
            "false" => Some(Self::Flag(false)),
            number => number.parse().ok().filter(|n: &f64| n.is_finite()).map(Self::Number),
        }
    }
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Number(number) => write!(f, "{number:?}"),
        }
    }
}

/// All that the host says of the scene, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts(BTreeMap<String, Fact>);

impl Facts {
    /// Tells a fact; a fact told twice keeps what was told last.
    pub fn tell(&mut self, name: impl Into<String>, fact: Fact) {
        self.0.insert(name.into(), fact);
    }

    /// The fact of that name, if it was told.
    pub fn get(&self, name: &str) -> Option<Fact> {
        self.0.get(name).copied()
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Fact)> + '_ {
        self.0.iter().map(|(name, fact)| (name.as_str(), *fact))
    }
}

impl<N: Into<String>> FromIterator<(N, Fact)> for Facts {
    fn from_iter<I: IntoIterator<Item = (N, Fact)>>(facts: I) -> Self {
        Self(facts.into_iter().map(|(name, fact)| (name.into(), fact)).collect())
    }
}

/// What a condition takes a fact for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FactKind {
    /// True or false.
    Flag,
    /// A number.
    Number,
}

impl FactKind {
    /// The kind in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Flag => "true or false",
            Self::Number => "a number",
        }
    }
}

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition(Expression);

#[derive(Clone, Debug, PartialEq)]
enum Expression {
    Constant(bool),
    Flag(String),
    Compare(Side, Comparison, Side),
    Not(Box<Self>),
    And(Box<Self>, Box<Self>),
    Or(Box<Self>, Box<Self>),
}

#[derive(Clone, Debug, PartialEq)]
enum Side {
    Fact(String),
    Number(f64),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Different,
}

/// A condition that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionError {
    /// The bytes of the condition that are at fault.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl Condition {
    /// Reads a condition.
    ///
    /// # Errors
    /// The first mistake, with its bytes.
    pub fn parse(text: &str) -> Result<Self, ConditionError> {
        let tokens = tokens(text)?;
        let mut parser = Parser { text, tokens, next: 0, depth: 0 };
        let expression = parser.any()?;
        match parser.peek() {
            None => Ok(Self(expression)),
            Some(_) => Err(parser.expected("`and`, `or` or the end of the condition")),
        }
    }

    /// Holds when both hold.
    pub fn and(self, other: Self) -> Self {
        Self(Expression::And(Box::new(self.0), Box::new(other.0)))
    }

    /// Whether it holds, or may hold as far as the facts tell.
    pub fn evaluate(&self, facts: &Facts) -> bool {
        self.0.truth(facts).unwrap_or(true)
    }

    /// The facts that it asks for, and what it takes each for.
    pub fn facts(&self) -> Vec<(&str, FactKind)> {
        let mut all = Vec::new();
        self.0.collect(&mut all);
        all.sort_unstable();
        all.dedup();
        all
    }
}

impl Expression {
    /// `None` where the facts do not tell.
    fn truth(&self, facts: &Facts) -> Option<bool> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Flag(name) => match facts.get(name)? {
                Fact::Flag(flag) => Some(flag),
                Fact::Number(_) => None,
            },
            Self::Compare(left, comparison, right) => comparison.holds(left.number(facts)?, right.number(facts)?),
            Self::Not(inner) => inner.truth(facts).map(|truth| !truth),
            Self::And(a, b) => match (a.truth(facts), b.truth(facts)) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (Some(true), Some(true)) => Some(true),
                _ => None,
            },
            Self::Or(a, b) => match (a.truth(facts), b.truth(facts)) {
                (Some(true), _) | (_, Some(true)) => Some(true),
                (Some(false), Some(false)) => Some(false),
                _ => None,
            },
        }
    }

    fn collect<'a>(&'a self, all: &mut Vec<(&'a str, FactKind)>) {
        match self {
            Self::Constant(_) => {}
            Self::Flag(name) => all.push((name, FactKind::Flag)),
            Self::Compare(left, _, right) => {
                for side in [left, right] {
                    if let Side::Fact(name) = side {
                        all.push((name, FactKind::Number));
                    }
                }
            }
            Self::Not(inner) => inner.collect(all),
            Self::And(a, b) | Self::Or(a, b) => {
                a.collect(all);
                b.collect(all);
            }
        }
    }
}

impl Side {
    fn number(&self, facts: &Facts) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Fact(name) => match facts.get(name)? {
                Fact::Number(number) => Some(number),
                Fact::Flag(_) => None,
            },
        }
    }
}

impl Comparison {
    const ALL: [(&'static str, Self); 6] = [
        ("<", Self::Less),
        ("<=", Self::AtMost),
        (">", Self::More),
        (">=", Self::AtLeast),
        ("==", Self::Equal),
        ("!=", Self::Different),
    ];

    fn named(sign: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|(name, _)| *name == sign).map(|(_, comparison)| comparison)
    }

    fn sign(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, comparison)| *comparison == self).map_or("", |(name, _)| name)
    }

    /// `None` where a number is not a number: nothing is known then.
    fn holds(self, left: f64, right: f64) -> Option<bool> {
        let order = left.partial_cmp(&right)?;
        Some(match self {
            Self::Less => order.is_lt(),
            Self::AtMost => order.is_le(),
            Self::More => order.is_gt(),
            Self::AtLeast => order.is_ge(),
            Self::Equal => order.is_eq(),
            Self::Different => order.is_ne(),
        })
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Flag(name) => f.write_str(name),
            Self::Compare(left, comparison, right) => write!(f, "{left} {} {right}", comparison.sign()),
            Self::Not(inner) if matches!(**inner, Self::Flag(_) | Self::Constant(_) | Self::Not(_)) => write!(f, "not {inner}"),
            Self::Not(inner) => write!(f, "not ({inner})"),
            Self::And(a, b) => {
                a.fmt_inside_and(f)?;
                f.write_str(" and ")?;
                b.fmt_inside_and(f)
            }
            Self::Or(a, b) => write!(f, "{a} or {b}"),
        }
    }
}

impl Expression {
    fn fmt_inside_and(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if matches!(self, Self::Or(..)) { write!(f, "({self})") } else { write!(f, "{self}") }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fact(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
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
    let message = format!("{} does not belong into a condition", crate::diagnostic::quote(&rest[..length]));
    ConditionError { span: at..at + length, message, help: help.into() }
}

/// Brackets and `not`s within each other.
const DEEPEST: usize = 64;
/// Words and signs in one condition.
const LONGEST: usize = 512;

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
            Some(text) => format!("there is {}", crate::diagnostic::quote(text)),
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
            left = Expression::And(Box::new(left), Box::new(self.single()?));
        }
        Ok(left)
    }

    fn single(&mut self) -> Result<Expression, ConditionError> {
        if self.depth >= DEEPEST || self.tokens.len() > LONGEST {
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
                self.refuse_flag()?;
                Ok(Expression::Compare(left, comparison, self.side()?))
            }
            (Side::Fact(name), None) => Ok(Expression::Flag(name)),
            (Side::Number(_), None) => Err(self.expected("a comparison such as `<`")),
        }
    }

    fn refuse_flag(&self) -> Result<(), ConditionError> {
        match self.peek() {
            Some(Token::Word(word)) if word == "true" || word == "false" => Err(ConditionError {
                span: self.span(),
                message: "only numbers are compared".into(),
                help: "write `emissive` for what must be true and `not emissive` for what must be false".into(),
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
