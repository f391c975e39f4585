//! RON as a tree in which everything knows its location.
//!
//! Repeated keys are kept, a comment after a value does not belong to its location, and whole numbers stay apart from
//! others. What could not be read is [`Tree::Broken`], and its error has been reported: nobody reports it again.

use afterimage_base::diagnostic::Spanned;

/// A value and its location.
pub(crate) type Item = Spanned<Tree>;
/// The name of a field and its value.
pub(crate) type Field = (Spanned<String>, Item);

/// The entries between two brackets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group<T> {
    pub(crate) entries: Vec<T>,
    /// True if more may be written there than could be read.
    pub(crate) is_partial: bool,
}

impl<T> Default for Group<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), is_partial: false }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Tree {
    Bool(bool),
    Int(i64),
    /// Any other number, finite or not.
    Float(f64),
    Text(String),
    Name(String),
    List(Vec<Item>),
    Map(Group<(Item, Item)>),
    /// `(a, b)` or `Name(a, b)`.
    Tuple(Option<Spanned<String>>, Vec<Item>),
    /// `(key: value)`, `Name(key: value)` or `Name()`.
    Struct(Option<Spanned<String>>, Group<Field>),
    /// Characters and bytes, which pipelines have no use for.
    Other,
    /// A value with a syntax error.
    Broken,
}

impl Tree {
    pub(crate) fn describe(&self) -> &'static str {
        match self {
            Self::Bool(_) => "a flag",
            Self::Int(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Text(_) => "a text in quotes",
            Self::Name(_) => "a bare name",
            Self::List(_) => "a list in `[ ]`",
            Self::Map(_) => "a map in `{ }`",
            Self::Tuple(None, _) => "values in parentheses",
            Self::Struct(None, _) => "fields in parentheses",
            Self::Tuple(Some(_), _) | Self::Struct(Some(_), _) => "a name with parentheses",
            Self::Other | Self::Broken => "a value of another kind",
        }
    }

    /// A number, whole or not.
    pub(crate) fn number(&self) -> Option<f64> {
        match *self {
            Self::Int(whole) => Some(whole as f64),
            Self::Float(number) => Some(number),
            _ => None,
        }
    }

    /// Returns whether it could not be read.
    pub(crate) fn is_broken(&self) -> bool {
        *self == Self::Broken
    }
}
