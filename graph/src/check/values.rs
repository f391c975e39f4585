//! Values of parameters, conditions and formats: from what is written to what is meant.

use super::build::Builder;
use super::condition::{Condition, FactKind};
use super::files::{join, unreadable};
use crate::document::{Item, Tree, renamed};
use crate::node::NodeKind;
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, did_you_mean, list, quote};
use afterimage_base::image::Format;
use afterimage_base::value::{ChoiceName, FileValue, Param, Type, Value};

impl Builder<'_> {
    /// The value of a parameter; an error is reported otherwise.
    pub(super) fn value(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Option<Value> {
        if item.value.is_broken() {
            return None;
        }
        let value = match self.typed(kind, param, item) {
            Ok(value) => value,
            Err(diagnostic) => {
                self.report(diagnostic);
                return None;
            }
        };
        if let Err(why) = param.accepts(&value) {
            let diagnostic = Diagnostic::error("out-of-domain", why).at(&item.location, "");
            self.report(diagnostic.help(about(param)));
            return None;
        }
        Some(value)
    }

    fn typed(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Result<Value, Diagnostic> {
        Ok(match (param.ty, &item.value) {
            (Type::Bool, Tree::Bool(flag)) => Value::Bool(*flag),
            (Type::Int, Tree::Int(whole)) => Value::Int(*whole),
            (Type::Float, Tree::Int(_) | Tree::Float(_)) => Value::Float(number(item).unwrap_or_default()),
            (Type::Vector(n), Tree::Tuple(None, items)) => vector(kind, param, n, items, &item.location)?,
            (Type::Choice(choices), Tree::Name(name)) => match choices.iter().find(|choice| choice.name == name) {
                Some(choice) => Value::Choice(choice.name),
                None => return Err(unknown_choice(param, choices, name, &item.location)),
            },
            (Type::File, Tree::Text(path)) => self.file(&Spanned::new(path.clone(), item.location.clone()))?,
            _ => return Err(wrong_type(kind, param, item)),
        })
    }

    fn file(&mut self, named: &Spanned<String>) -> Result<Value, Diagnostic> {
        let path = named.value.clone();
        if path.is_empty() {
            return Ok(Value::File(FileValue::default()));
        }
        let bytes = self.files.bytes(&join(&named.location.file, &path)).map_err(|why| unreadable(named, &why))?;
        Ok(Value::File(FileValue { path, bytes: Some(bytes) }))
    }

    /// The condition of `when`.
    pub(super) fn condition(&mut self, scope: usize, item: &Item) -> Option<Condition> {
        let Tree::Text(text) = &item.value else {
            if item.value.is_broken() {
                return None;
            }
            let message = format!("`when` is a condition in quotes, not {}", item.value.describe());
            let help = "write it as `when: \"emissive and illuminance < 10\"`";
            self.report(Diagnostic::error("wrong-type", message).at(&item.location, "").help(help));
            return None;
        };
        let inner = self.inner_location(item, text);
        match Condition::parse(text) {
            Ok(condition) => {
                self.facts_of(scope, &condition, inner.as_ref().unwrap_or(&item.location));
                Some(condition)
            }
            Err(error) => {
                let location = inner.map_or(item.location.clone(), |inner| inner.part(error.span));
                self.report(Diagnostic::error("condition", error.message).at(&location, "").help(error.help));
                None
            }
        }
    }

    /// The location of a text within its quotes; `None` if escapes make it longer than it is.
    fn inner_location(&self, item: &Item, text: &str) -> Option<Location> {
        let written = self.diagnostics.sources.text(&item.location.file)?.get(item.location.span())?;
        let start = written.find(text)?;
        Some(item.location.part(start..start + text.len()))
    }

    /// Facts must be declared where the file declares facts, and be of one kind everywhere.
    fn facts_of(&mut self, scope: usize, condition: &Condition, location: &Location) {
        for (name, kind) in condition.uses() {
            let location = self.fact_location(location, name);
            if let Some(known) = &self.scopes[scope].facts
                && !known.iter().any(|known| known == name)
            {
                let help = if known.is_empty() {
                    "the section `facts` is empty".into()
                } else {
                    format!("the section `facts` has {}", list(known.iter().map(String::as_str), 8))
                };
                let diagnostic = Diagnostic::error("unknown-fact", format!("no fact is called {}", quote(name)))
                    .at(&location, "")
                    .help(help)
                    .maybe_help(did_you_mean(name, known.iter().map(String::as_str)));
                self.report(diagnostic);
                continue;
            }
            self.fact_kind(name, kind, &location);
        }
    }

    fn fact_location(&self, condition: &Location, name: &str) -> Location {
        let text = self.diagnostics.sources.text(&condition.file).and_then(|text| text.get(condition.span()));
        match text.and_then(|text| text.find(name)) {
            Some(start) => condition.part(start..start + name.len()),
            None => condition.clone(),
        }
    }

    fn fact_kind(&mut self, name: &str, kind: FactKind, location: &Location) {
        let (known, first) = self.facts.entry(name.to_owned()).or_insert_with(|| (kind, location.clone()));
        if *known != kind {
            let message =
                format!("the fact {} is used as {} and as {}", quote(name), known.describe(), kind.describe());
            let diagnostic = Diagnostic::error("fact-kind", message)
                .at(location, format!("here it is {}", kind.describe()))
                .also(first, format!("here it is {}", known.describe()));
            self.report(diagnostic.help("the host can tell it only one way: use two names"));
        }
    }

    /// The value of `format`.
    pub(super) fn format(&mut self, item: &Item) -> Option<Format> {
        let names = Format::ALL.map(Format::name);
        let diagnostic = match &item.value {
            Tree::Name(name) => match Format::named(name) {
                Some(format) => return Some(format),
                None => Diagnostic::error("unknown-format", format!("no format is called {}", quote(name)))
                    .at(&item.location, "")
                    .help(format!("the formats are {}", list(names, names.len())))
                    .maybe_help(did_you_mean(name, names)),
            },
            Tree::Text(name) if Format::named(name).is_some() => {
                Diagnostic::error("wrong-type", "`format` is the bare name of a format")
                    .at(&item.location, "this is a text in quotes")
                    .help(format!("write {} without quotes", quote(name)))
            }
            Tree::Broken => return None,
            other => Diagnostic::error("wrong-type", "`format` is the bare name of a format")
                .at(&item.location, format!("this is {}", other.describe()))
                .help(format!("the formats are {}", list(names, names.len()))),
        };
        self.report(diagnostic);
        None
    }

    /// The value of `label`.
    pub(super) fn label(&mut self, item: &Item) -> Option<String> {
        if let Tree::Text(label) = &item.value {
            return Some(label.clone());
        }
        if item.value.is_broken() {
            return None;
        }
        let diagnostic = Diagnostic::error("wrong-type", "`label` is a text in quotes");
        self.report(diagnostic.at(&item.location, format!("this is {}", item.value.describe())));
        None
    }
}

fn number(item: &Item) -> Option<f64> {
    match item.value {
        Tree::Int(whole) => Some(whole as f64),
        Tree::Float(number) => Some(number),
        _ => None,
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
        *slot = number(item).ok_or_else(|| {
            let message = format!("{} of {} takes {n} numbers", quote(&param.name), quote(kind.name()));
            let seen = format!("this is {}", item.value.describe());
            Diagnostic::error("wrong-type", message).at(&item.location, seen).help(about(param))
        })?;
    }
    Ok(Value::Vector(numbers, n))
}

fn unknown_choice(param: &Param, choices: &[ChoiceName], name: &str, location: &Location) -> Diagnostic {
    if let Some(choice) = choices.iter().find(|choice| choice.former == name) {
        return renamed(&Spanned::new(name.to_owned(), location.clone()), choice.name);
    }
    let names = || choices.iter().map(|choice| choice.name);
    Diagnostic::error("unknown-choice", format!("{} has no value {}", quote(&param.name), quote(name)))
        .at(location, "")
        .help(format!("its values are {}", list(names(), 16)))
        .maybe_help(did_you_mean(name, names()))
}

fn wrong_type(kind: &NodeKind, param: &Param, item: &Item) -> Diagnostic {
    let message = format!("{} of {} is {}", quote(&param.name), quote(kind.name()), param.ty.describe());
    let diagnostic =
        Diagnostic::error("wrong-type", message).at(&item.location, format!("this is {}", item.value.describe()));
    match (param.ty, &item.value) {
        (Type::Choice(choices), Tree::Text(name)) if choices.iter().any(|choice| choice.name == name) => {
            diagnostic.help(format!("write {} without quotes", quote(name)))
        }
        (Type::Bool, Tree::Name(name)) if name.eq_ignore_ascii_case("true") || name.eq_ignore_ascii_case("false") => {
            diagnostic.help(format!("write {}", quote(&name.to_lowercase())))
        }
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 && x.abs() < 1e15 => diagnostic.help(format!("write `{x:.0}`")),
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 => diagnostic.help("the number is too large"),
        (Type::Vector(n), Tree::List(items)) if items.len() == n => diagnostic.help("write parentheses, not brackets"),
        (_, Tree::Text(_)) => diagnostic.help("only ports take the name of a node; a parameter takes a value"),
        _ => diagnostic.help(about(param)),
    }
}

/// The first sentence of the parameter's manual, and its default.
fn about(param: &Param) -> String {
    let doc = param.doc.replace('\n', " ");
    let sentence = doc.split_inclusive(". ").next().unwrap_or_default().trim().trim_end_matches('.').to_owned();
    format!("{}: {sentence} (default {})", quote(&param.name), param.default)
}
