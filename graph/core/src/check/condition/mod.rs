//! Conditions over facts: `when: "emissive and illuminance < 10"`.
//!
//! A condition that depends on a fact which the host does not set holds: a node is skipped only if it is known to be
//! unneeded.

mod parse;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

pub use parse::ConditionError;

/// A value of a fact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fact {
    /// Something is so or not.
    Flag(bool),
    /// Something has this amount.
    Number(f64),
}

impl From<bool> for Fact {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<f64> for Fact {
    fn from(number: f64) -> Self {
        Self::Number(number)
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

/// Facts about the scene, by name, as the host sets them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts(BTreeMap<String, Fact>);

impl Facts {
    /// Sets a fact. The last value counts.
    pub fn set(&mut self, name: impl Into<String>, fact: impl Into<Fact>) {
        self.0.insert(name.into(), fact.into());
    }

    /// Makes a fact unknown again.
    pub fn unset(&mut self, name: &str) {
        self.0.remove(name);
    }

    /// The fact of that name, if it is set.
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

/// Type of a fact, by its use in conditions.
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

/// A condition. Its parts are shared: the condition of a pipeline that is used as a node is part of that of every node
/// inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition(Arc<Expression>);

#[derive(Clone, Debug, PartialEq)]
enum Expression {
    Constant(bool),
    Flag(String),
    Compare(Side, Comparison, Side),
    Not(Box<Self>),
    And(Arc<Self>, Arc<Self>),
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

impl Condition {
    /// Holds when both hold.
    pub fn and(self, other: Self) -> Self {
        Self(Arc::new(Expression::And(self.0, other.0)))
    }

    /// Returns whether it holds. A condition that depends on an unknown fact holds.
    pub fn holds(&self, facts: &Facts) -> bool {
        self.0.truth(facts).unwrap_or(true)
    }

    /// The names of the facts that it asks for, sorted.
    pub fn facts(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.uses().into_iter().map(|(name, _)| name).collect();
        names.dedup();
        names
    }

    /// The facts that it asks for, sorted, and what it takes each for.
    pub fn uses(&self) -> Vec<(&str, FactKind)> {
        let mut all = Vec::new();
        self.0.collect(&mut all);
        all.sort_unstable();
        all.dedup();
        all
    }
}

impl Expression {
    /// The value; `None` if it depends on an unknown fact.
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
            Self::And(a, b) => [a, b].into_iter().for_each(|part| part.collect(all)),
            Self::Or(a, b) => [a, b].into_iter().for_each(|part| part.collect(all)),
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
            Self::Not(inner) if matches!(**inner, Self::Flag(_) | Self::Constant(_) | Self::Not(_)) => {
                write!(f, "not {inner}")
            }
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
