//! RON as a tree in which everything knows its place.
//!
//! `ron` reads; this only keeps the places. A value is read as a borrowed [`RawValue`], so its place is the difference of two addresses,
//! and every level is read again by itself; what is plain enough to be taken as it stands is not read once more. Three traps are avoided here, once: repeated keys are kept, not overwritten; a comment after
//! a value does not belong to its place; and whole numbers stay apart from others.

use std::sync::Arc;

use ron::de::Deserializer;
use ron::error::SpannedError;
use ron::options::Options;
use ron::value::RawValue;
use serde::Deserialize;
use serde::de::{self, IgnoredAny, MapAccess, SeqAccess, Visitor};

use afterimage_base::diagnostic::{Place, Spanned};

/// Brackets within brackets; a pipeline needs about five.
const DEEPEST: usize = 32;

/// A value and its place.
pub(crate) type Item = Spanned<Tree>;
/// The name of a field and its value.
pub(crate) type Field = (Spanned<String>, Item);

/// What is written at a place.
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
    Map(Vec<(Item, Item)>),
    /// `(a, b)` or `Name(a, b)`.
    Tuple(Option<Spanned<String>>, Vec<Item>),
    /// `(key: value)`, `Name(key: value)` or `Name()`.
    Struct(Option<Spanned<String>>, Vec<Field>),
    /// Characters, bytes and ranges, which pipelines have no use for.
    Other,
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
            Self::Other => "a value of another kind",
        }
    }
}

/// Where and why `ron` could not go on.
pub(crate) struct Unreadable {
    pub(crate) at: usize,
    pub(crate) why: ron::Error,
}

/// The tree of a whole file.
pub(crate) fn read(file: &Arc<str>, text: &str) -> Result<Item, Unreadable> {
    let reader = Reader { file, text };
    let mut whole = reader.open(text)?;
    let start = whole.remainder();
    IgnoredAny::deserialize(&mut whole).map_err(|why| reader.unreadable(text, whole.span_error(why)))?;
    let value = &start[..start.len() - whole.remainder().len()];
    whole.end().map_err(|why| reader.unreadable(text, whole.span_error(why)))?;
    reader.value(value)
}

fn options() -> Options {
    Options::default().with_recursion_limit(DEEPEST)
}

struct Reader<'a> {
    file: &'a Arc<str>,
    text: &'a str,
}

impl<'a> Reader<'a> {
    fn offset(&self, part: &str) -> usize {
        part.as_ptr() as usize - self.text.as_ptr() as usize
    }

    fn place(&self, part: &str) -> Place {
        let start = self.offset(part);
        Place::new(self.file, start..start + part.len())
    }

    fn open(&self, part: &'a str) -> Result<Deserializer<'a>, Unreadable> {
        Deserializer::from_str_with_options(part, &options()).map_err(|error| self.unreadable(part, error))
    }

    fn unreadable(&self, part: &str, error: SpannedError) -> Unreadable {
        let lines: usize = part.split_inclusive('\n').take(error.span.start.line.saturating_sub(1)).map(str::len).sum();
        let column = part[lines..].char_indices().nth(error.span.start.col.saturating_sub(1));
        let at = lines + column.map_or(part.len() - lines, |(at, _)| at);
        Unreadable { at: self.offset(part) + at, why: error.code }
    }

    /// The one value in `part`, without the space and the comments around it.
    fn item(&self, part: &'a str) -> Result<Item, Unreadable> {
        if !part.contains('/') {
            return self.value(part.trim_matches(is_space));
        }
        let mut rest = self.open(part)?;
        let start = rest.remainder();
        IgnoredAny::deserialize(&mut rest).map_err(|why| self.unreadable(part, rest.span_error(why)))?;
        self.value(&start[..start.len() - rest.remainder().len()])
    }

    /// A value with nothing around it.
    fn value(&self, value: &'a str) -> Result<Item, Unreadable> {
        match name_length(value) {
            Some(length) => self.named(&value[..length], &value[length..]),
            None => Ok(Spanned::new(self.unnamed(value)?, self.place(value))),
        }
    }

    /// A name and perhaps what follows in parentheses.
    fn named(&self, name: &'a str, rest: &'a str) -> Result<Item, Unreadable> {
        let plain = Spanned::new(name.trim_start_matches("r#").to_owned(), self.place(name));
        let parentheses = self.open(rest)?.remainder();
        if !parentheses.starts_with('(') {
            let tree = match name {
                "true" | "false" => Tree::Bool(name == "true"),
                "inf" | "inff32" | "inff64" => Tree::Float(f64::INFINITY),
                "NaN" | "NaNf32" | "NaNf64" => Tree::Float(f64::NAN),
                _ => Tree::Name(plain.value),
            };
            return Ok(Spanned::new(tree, plain.place));
        }
        let place = Place::new(self.file, plain.place.start..self.offset(parentheses) + parentheses.len());
        let tree = match self.parts(parentheses)? {
            Parts::Fields(fields) => Tree::Struct(Some(plain), fields),
            Parts::Items(items) if items.is_empty() => Tree::Struct(Some(plain), Vec::new()),
            Parts::Items(items) => Tree::Tuple(Some(plain), items),
            Parts::Entries(_) => Tree::Other,
        };
        Ok(Spanned::new(tree, place))
    }

    fn unnamed(&self, value: &'a str) -> Result<Tree, Unreadable> {
        let is_text = value.starts_with('"') || value.starts_with("r\"") || value.starts_with("r#");
        Ok(match value.chars().next() {
            _ if is_text => match plain_text(value) {
                Some(plain) => Tree::Text(plain.to_owned()),
                None => ron::from_str(value).map_or(Tree::Other, Tree::Text),
            },
            Some('[' | '{' | '(') => match self.parts(value)? {
                Parts::Fields(fields) => Tree::Struct(None, fields),
                Parts::Entries(entries) => Tree::Map(entries),
                Parts::Items(items) if value.starts_with('[') => Tree::List(items),
                Parts::Items(items) => Tree::Tuple(None, items),
            },
            _ => number(value),
        })
    }

    /// What is between brackets.
    fn parts(&self, value: &'a str) -> Result<Parts, Unreadable> {
        let mut inside = self.open(value)?;
        let visitor = PartsVisitor { is_map: value.starts_with('{') };
        let parts = de::Deserializer::deserialize_any(&mut inside, visitor);
        match parts.map_err(|why| self.unreadable(value, inside.span_error(why)))? {
            RawParts::Fields(fields) => {
                let field = |(name, value): (&'a str, &'a RawValue)| {
                    Ok((Spanned::new(name.to_owned(), self.place(name)), self.item(value.get_ron())?))
                };
                Ok(Parts::Fields(fields.into_iter().map(field).collect::<Result<_, _>>()?))
            }
            RawParts::Entries(entries) => {
                let entry = |(key, value): (&'a RawValue, &'a RawValue)| {
                    Ok((self.item(key.get_ron())?, self.item(value.get_ron())?))
                };
                Ok(Parts::Entries(entries.into_iter().map(entry).collect::<Result<_, _>>()?))
            }
            RawParts::Items(items) => {
                Ok(Parts::Items(items.into_iter().map(|item| self.item(item.get_ron())).collect::<Result<_, _>>()?))
            }
        }
    }
}

/// The length of the name that the value begins with, if it begins with one.
fn name_length(value: &str) -> Option<usize> {
    let is_inner = |c: char| c.is_alphanumeric() || c == '_';
    let (skip, rest) = match value.strip_prefix("r#") {
        Some(rest) => (2, rest),
        None => (0, value),
    };
    let first = rest.chars().next()?;
    let is_quoted =
        rest.starts_with("r\"") || rest.starts_with("b\"") || rest.starts_with("b'") || rest.starts_with("br");
    if !(first.is_alphabetic() || first == '_') || (is_quoted && is_closed_by_quote(value)) {
        return None;
    }
    let is_end = |c: char| !(is_inner(c) || (skip > 0 && ".+-".contains(c)));
    Some(skip + rest.find(is_end).unwrap_or(rest.len()))
}

fn is_closed_by_quote(value: &str) -> bool {
    value.ends_with(['"', '\'', '#'])
}

/// What `ron` takes for space between values.
pub(super) fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}')
}

/// What is between quotes where it stands for itself.
fn plain_text(value: &str) -> Option<&str> {
    let inside = value.strip_prefix('"')?.strip_suffix('"')?;
    (!inside.contains(['\\', '"'])).then_some(inside)
}

/// A decimal number as everybody writes it.
fn plain_number(value: &str) -> Option<Tree> {
    let digits = value.strip_prefix('-').unwrap_or(value);
    let are_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    match digits.split_once('.') {
        Some((whole, rest)) if are_digits(whole) && are_digits(rest) => value.parse().ok().map(Tree::Float),
        None if are_digits(digits) && !digits.starts_with('0') => value.parse().ok().map(Tree::Int),
        _ => None,
    }
}

fn number(value: &str) -> Tree {
    if let Some(plain) = plain_number(value) {
        return plain;
    }
    // `ron` reads a byte literal as a number too.
    if value.starts_with('b') {
        return Tree::Other;
    }
    match ron::from_str::<i64>(value) {
        Ok(whole) => Tree::Int(whole),
        Err(_) => ron::from_str::<f64>(value).map_or(Tree::Other, Tree::Float),
    }
}

enum Parts {
    Fields(Vec<Field>),
    Entries(Vec<(Item, Item)>),
    Items(Vec<Item>),
}

enum RawParts<'a> {
    Fields(Vec<(&'a str, &'a RawValue)>),
    Entries(Vec<(&'a RawValue, &'a RawValue)>),
    Items(Vec<&'a RawValue>),
}

struct PartsVisitor {
    is_map: bool,
}

impl<'de> Visitor<'de> for PartsVisitor {
    type Value = RawParts<'de>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("something in brackets")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        if self.is_map {
            let mut entries = Vec::new();
            while let Some(entry) = map.next_entry()? {
                entries.push(entry);
            }
            return Ok(RawParts::Entries(entries));
        }
        let mut fields = Vec::new();
        while let Some(field) = map.next_entry()? {
            fields.push(field);
        }
        Ok(RawParts::Fields(fields))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            items.push(item);
        }
        Ok(RawParts::Items(items))
    }

    fn visit_unit<E: de::Error>(self) -> Result<Self::Value, E> {
        Ok(RawParts::Items(Vec::new()))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Tree, number, plain_number, plain_text, read};

    /// What is taken as it stands is what `ron` would have read.
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
            assert_eq!(plain, number(text), "{text}");
            taken += 1;
        }
        assert!(taken >= 8, "only {taken} numbers are plain");
        for text in ["\"\"", "\"a b\"", "\"ü\n\"", "\"a\\tb\"", "\"\\\"\"", "\"/* no comment */\""] {
            let plain = plain_text(text).map(str::to_owned);
            assert!(plain.is_none_or(|plain| Ok(plain) == ron::from_str::<String>(text)), "{text}");
        }
    }

    #[test]
    fn places_are_those_of_the_values_alone() {
        let text = "\u{200E}( \"a\":\u{2028}1.5 // a / comment\n, \"b\" : /* one */ \"x//y\" /* two */ , \"c\":\t[ 1,2 ]\u{85})"
            .replace('(', "{")
            .replace(')', "}");
        let file: Arc<str> = "test".into();
        let Ok(tree) = read(&file, &text) else { panic!("{text} is good RON") };
        let Tree::Map(entries) = tree.value else { panic!("{text} is a map") };
        let values: Vec<&str> = entries.iter().map(|(_, value)| &text[value.place.span()]).collect();
        assert_eq!(values, ["1.5", "\"x//y\"", "[ 1,2 ]"]);
    }
}
