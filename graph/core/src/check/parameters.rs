//! Values of parameters: their types and domains.

use super::fields::FieldReader;
use crate::document::{Item, Tree};
use crate::node::NodeKind;
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, list, quote};
use afterimage_base::value::{ChoiceName, FileValue, Param, Type, Value};

impl FieldReader<'_> {
    /// The value of a parameter; an error is reported otherwise.
    pub(super) fn value(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Option<Value> {
        if item.value.is_broken() {
            return None;
        }
        let value = match self.typed(kind, param, item) {
            Ok(value) => value,
            Err(diagnostic) => {
                self.reports.push(diagnostic);
                return None;
            }
        };
        if let Err(why) = param.accepts(&value) {
            let diagnostic = Diagnostic::error("out-of-domain", why).at(&item.location, "");
            self.reports.push(diagnostic.help(about(param)));
            return None;
        }
        Some(value)
    }

    fn typed(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Result<Value, Diagnostic> {
        Ok(match (param.ty, &item.value) {
            (Type::Bool, Tree::Bool(flag)) => Value::Bool(*flag),
            (Type::Int, Tree::Int(whole)) => Value::Int(*whole),
            (Type::Float, Tree::Int(_) | Tree::Float(_)) => Value::Float(item.value.number().unwrap_or_default()),
            (Type::Vector(n), Tree::Tuple(None, items)) => vector(kind, param, n, items, &item.location)?,
            (Type::Choice(choices), Tree::Name(name)) => match choices.iter().find(|choice| choice.name == name) {
                Some(choice) => Value::Choice(choice.name),
                None => return Err(unknown_choice(param, choices, name, &item.location)),
            },
            (Type::Text, Tree::Text(text)) => Value::Text(text.as_str().into()),
            (Type::File, Tree::Text(path)) => self.file(&Spanned::new(path.clone(), item.location.clone()))?,
            _ => return Err(wrong_type(kind, param, item)),
        })
    }

    fn file(&mut self, named: &Spanned<String>) -> Result<Value, Diagnostic> {
        let path = named.value.clone();
        if path.is_empty() {
            return Ok(Value::File(FileValue::default()));
        }
        let bytes = self.used.bytes(named)?;
        Ok(Value::File(FileValue { path: path.into(), bytes: Some(bytes.into()) }))
    }
}

fn vector(kind: &NodeKind, param: &Param, n: usize, items: &[Item], location: &Location) -> Result<Value, Diagnostic> {
    if items.len() != n {
        let message =
            format!("{} of {} takes {n} numbers, not {}", quote(&param.name), quote(kind.name()), items.len());
        return Err(Diagnostic::error("wrong-type", message).at(location, "").help(about(param)));
    }
    let mut numbers = [0.0; 4];
    for (slot, item) in numbers.iter_mut().zip(items) {
        *slot = item.value.number().ok_or_else(|| {
            let message = format!("{} of {} takes {n} numbers", quote(&param.name), quote(kind.name()));
            let seen = format!("this is {}", item.value.describe());
            Diagnostic::error("wrong-type", message).at(&item.location, seen).help(about(param))
        })?;
    }
    Ok(Value::Vector(numbers, n))
}

fn unknown_choice(param: &Param, choices: &[ChoiceName], name: &str, location: &Location) -> Diagnostic {
    let names = || choices.iter().map(|choice| choice.name);
    Diagnostic::error("unknown-choice", format!("{} has no value {}", quote(&param.name), quote(name)))
        .at(location, "")
        .help(format!("its values are {}", list(names(), 16)))
        .did_you_mean(name, names())
}

fn wrong_type(kind: &NodeKind, param: &Param, item: &Item) -> Diagnostic {
    let message = format!("{} of {} is {}", quote(&param.name), quote(kind.name()), param.ty.describe());
    let diagnostic =
        Diagnostic::error("wrong-type", message).at(&item.location, format!("this is {}", item.value.describe()));
    match (param.ty, &item.value) {
        (Type::Choice(choices), Tree::Text(name)) if choices.iter().any(|choice| choice.name == name) => {
            diagnostic.help(format!("write {} without quotes", quote(name))).rewrite(name)
        }
        (Type::Bool, Tree::Name(name)) if name.eq_ignore_ascii_case("true") || name.eq_ignore_ascii_case("false") => {
            diagnostic.help(format!("write {}", quote(&name.to_lowercase()))).rewrite(name.to_lowercase())
        }
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 && x.abs() < 1e15 => {
            diagnostic.help(format!("write `{x:.0}`")).rewrite(format!("{x:.0}"))
        }
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 => diagnostic.help("the number is too large"),
        (Type::Vector(n), Tree::List(items)) if items.len() == n => diagnostic.help("write parentheses, not brackets"),
        (Type::Int | Type::Float, Tree::Text(text)) if with_point(text).is_some() => {
            let number = with_point(text).unwrap_or_default();
            diagnostic.help(format!("write {} without quotes", quote(&number))).rewrite(number)
        }
        (Type::Choice(choices), Tree::Text(name)) => {
            let names = choices.iter().map(|choice| choice.name);
            diagnostic.help("its values are names without quotes").did_you_mean(name, names)
        }
        (Type::File | Type::Text, Tree::Name(name)) => {
            diagnostic.help(format!("write it in quotes: `{}: \"{name}...\"`", param.name))
        }
        (_, Tree::Text(_)) => diagnostic.help("only ports take the name of a node; a parameter takes a value"),
        _ => diagnostic.help(about(param)),
    }
}

/// The number that a text holds, with a point: `0.15` for `0,15`.
pub(super) fn with_point(text: &str) -> Option<String> {
    let number = text.trim().replacen(',', ".", 1);
    number.parse::<f64>().is_ok_and(f64::is_finite).then_some(number)
}

/// The first sentence of the parameter's manual, and its default.
fn about(param: &Param) -> String {
    let doc = param.doc.replace('\n', " ");
    let sentence = doc.split_inclusive(". ").next().unwrap_or_default().trim().trim_end_matches('.').to_owned();
    format!("{}: {sentence} (default {})", quote(&param.name), param.default)
}
