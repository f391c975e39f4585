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
    /// Whether more may be written there than could be read.
    pub(crate) is_partial: bool,
}

impl<T> Default for Group<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), is_partial: false }
    }
}

/// What is written at a location.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Tree {
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// Any other number, finite or not.
    Float(f64),
    /// A string.
    Text(String),
    /// A bare name.
    Name(String),
    /// `[ ... ]`.
    List(Vec<Item>),
    /// `{ key: value }`.
    Map(Group<(Item, Item)>),
    /// `(a, b)` or `Name(a, b)`.
    Tuple(Option<Spanned<String>>, Vec<Item>),
    /// `(key: value)`, `Name(key: value)` or `Name()`.
    Struct(Option<Spanned<String>>, Group<Field>),
    /// Characters and bytes, which pipelines have no use for.
    Other,
    /// What could not be read.
    Broken,
}

impl Tree {
    /// What it is, in words.
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

    /// Whether it could not be read.
    pub(crate) fn is_broken(&self) -> bool {
        *self == Self::Broken
    }

    /// The value of a word without parentheses.
    pub(super) fn word(word: &str) -> Self {
        match word {
            "true" | "false" => Self::Bool(word == "true"),
            "inf" | "inff32" | "inff64" => Self::Float(f64::INFINITY),
            "NaN" | "NaNf32" | "NaNf64" => Self::Float(f64::NAN),
            _ => Self::Name(plain_name(word).to_owned()),
        }
    }

    /// The number that is written so.
    pub(super) fn number(written: &str) -> Option<Self> {
        plain_number(written).or_else(|| match ron::from_str::<i64>(written) {
            Ok(whole) => Some(Self::Int(whole)),
            Err(_) => ron::from_str::<f64>(written).ok().map(Self::Float),
        })
    }

    /// The text that is written so, quotes included.
    pub(super) fn text(written: &str) -> Option<Self> {
        match plain_text(written) {
            Some(plain) => Some(Self::Text(plain.to_owned())),
            None => ron::from_str(written).ok().map(Self::Text),
        }
    }
}

/// A name without the sign of raw names.
pub(super) fn plain_name(word: &str) -> &str {
    word.strip_prefix("r#").unwrap_or(word)
}

/// What is between quotes and needs no decoding.
fn plain_text(written: &str) -> Option<&str> {
    let inside = written.strip_prefix('"')?.strip_suffix('"')?;
    (!inside.contains(['\\', '"'])).then_some(inside)
}

/// A decimal number as everybody writes it.
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
    use super::{Tree, plain_number, plain_text};

    /// What is taken without `ron` is what `ron` reads.
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
            assert_eq!(Some(plain), Tree::number(text), "{text}");
            taken += 1;
        }
        assert!(taken >= 8, "only {taken} numbers are plain");
        for text in ["\"\"", "\"a b\"", "\"ü\n\"", "\"a\\tb\"", "\"\\\"\"", "\"/* no comment */\""] {
            let plain = plain_text(text).map(str::to_owned);
            assert!(plain.is_none_or(|plain| Ok(plain) == ron::from_str::<String>(text)), "{text}");
        }
    }
}
