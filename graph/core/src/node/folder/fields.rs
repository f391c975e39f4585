//! Fields of a `node.ron`, read one by one.

use super::declaration::SizeRule;
use crate::document::{Field, Group, Item, Tree, doubled};
use crate::node::{Input, OutputState, PortType};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, is_control, list, quote};
use afterimage_base::image::ColorState;
use afterimage_base::value::{Type, Value};

/// The one of some named things that a name means.
pub(super) fn one_of<T: Copy, const N: usize>(
    ty: &Spanned<String>,
    what: &str,
    known: [(&'static str, T); N],
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    let found = known.iter().find(|(name, _)| *name == ty.value).map(|(_, value)| *value);
    if found.is_none() {
        let names = known.map(|(name, _)| name);
        let diagnostic =
            Diagnostic::error("unknown-type", format!("no {what} is called {}", quote(&ty.value))).at(&ty.location, "");
        let help = format!("there are {}", list(names, N));
        diagnostics.push(diagnostic.help(help).did_you_mean(&ty.value, names));
    }
    found
}

/// The fields of a thing, taken one by one; what is left in the end is a error.
pub(super) struct Fields<'d> {
    location: Location,
    what: &'static str,
    left: Vec<Field>,
    /// True if fields are missing because of errors that have been reported.
    is_partial: bool,
    pub(super) diagnostics: &'d mut Diagnostics,
}

impl<'d> Fields<'d> {
    pub(super) fn new(
        location: Location,
        what: &'static str,
        fields: Group<Field>,
        diagnostics: &'d mut Diagnostics,
    ) -> Self {
        let mut left: Vec<Field> = Vec::new();
        for (name, item) in fields.entries {
            match left.iter().find(|(known, _)| known.value == name.value) {
                Some((first, _)) => diagnostics.push(doubled(&name, &first.location, "field")),
                None => left.push((name, item)),
            }
        }
        Self { location, what, left, is_partial: fields.is_partial, diagnostics }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.left.iter().any(|(field, _)| field.value == name)
    }

    pub(super) fn take(&mut self, name: &str) -> Option<Item> {
        let at = self.left.iter().position(|(field, _)| field.value == name)?;
        Some(self.left.remove(at).1)
    }

    pub(super) fn required(&mut self, name: &str) -> Option<Item> {
        let item = self.take(name);
        if item.is_none() && !self.is_partial {
            let message = format!("{} needs {}", self.what, quote(name));
            let missing = Diagnostic::error("missing-field", message).at(&self.location, "");
            self.diagnostics.push(missing.help(format!("add `{name}: ...`; nodes/README.md has an example")));
        }
        item
    }

    pub(super) fn wrong(&mut self, name: &str, item: &Item, expected: &str) {
        if item.value.is_broken() {
            return;
        }
        let message = format!("{} is {expected}", quote(name));
        let seen = format!("this is {}", item.value.describe());
        self.diagnostics.push(Diagnostic::error("wrong-type", message).at(&item.location, seen));
    }

    pub(super) fn text(&mut self, name: &str) -> Option<Spanned<String>> {
        let item = self.required(name)?;
        match &item.value {
            Tree::Text(text) if is_shown(text) => Some(Spanned::new(text.clone(), item.location)),
            _ => {
                self.wrong(name, &item, "a text in quotes that is not empty and has no control characters");
                None
            }
        }
    }

    pub(super) fn flag(&mut self, name: &str) -> bool {
        match self.take(name) {
            Some(Item { value: Tree::Bool(flag), .. }) => flag,
            Some(item) => {
                self.wrong(name, &item, "`true` or `false`");
                false
            }
            None => false,
        }
    }

    pub(super) fn map(&mut self, name: &str) -> Vec<(Spanned<String>, Item)> {
        self.required(name).map_or_else(Vec::new, |item| self.entries(name, item))
    }

    pub(super) fn entries(&mut self, name: &str, item: Item) -> Vec<(Spanned<String>, Item)> {
        let Tree::Map(group) = item.value else {
            self.wrong(name, &item, "a map, `{ \"name\": Type(...) }`");
            return Vec::new();
        };
        let mut named: Vec<(Spanned<String>, Item)> = Vec::new();
        for (key, value) in group.entries {
            match key.value {
                Tree::Text(text) => {
                    let key = Spanned::new(text, key.location);
                    match named.iter().find(|(known, _)| known.value == key.value) {
                        Some((first, _)) => self.diagnostics.push(doubled(&key, &first.location, "name")),
                        None => named.push((key, value)),
                    }
                }
                // Entries from outside, where a bracket is missing.
                _ if group.is_partial => {}
                _ => self.wrong(name, &key, "a map whose names are in quotes"),
            }
        }
        named
    }

    pub(super) fn accepted(&mut self) -> Vec<ColorState> {
        match self.take("accepts") {
            None => Vec::new(),
            Some(Item { value: Tree::List(items), .. }) => {
                items.into_iter().filter_map(|item| self.state(item)).collect()
            }
            Some(item) => {
                self.wrong("accepts", &item, "a list of states, `[Scene, Exposed]`");
                Vec::new()
            }
        }
    }

    pub(super) fn state(&mut self, item: Item) -> Option<ColorState> {
        match item.value {
            Tree::Name(name) => {
                let states = ColorState::ALL.map(|state| (state.name(), state));
                one_of(&Spanned::new(name, item.location), "image state", states, self.diagnostics)
            }
            _ => {
                self.wrong("state", &item, "the bare name of an image state");
                None
            }
        }
    }

    pub(super) fn output_state(&mut self, inputs: &[(Input, Location)]) -> Option<OutputState> {
        let item = self.required("state")?;
        match &item.value {
            Tree::Name(_) => self.state(item).map(OutputState::Always),
            Tree::Tuple(Some(word), items) if word.value == "Same" => match items.as_slice() {
                [Item { value: Tree::Text(input), location }] => {
                    self.is_required_image(input, location, inputs);
                    Some(OutputState::Same(input.clone().into()))
                }
                _ => {
                    self.wrong("state", &item, "`Same(\"input\")` or an image state");
                    None
                }
            },
            _ => {
                self.wrong("state", &item, "`Same(\"input\")` or an image state");
                None
            }
        }
    }

    /// A state can follow only an input that is always there.
    pub(super) fn is_required_image(&mut self, input: &str, location: &Location, inputs: &[(Input, Location)]) {
        let fits = |port: &&Input| matches!(port.ty, PortType::Image | PortType::Pyramid) && !port.optional;
        let names = || inputs.iter().map(|(port, _)| port).filter(fits).map(|port| &*port.name);
        // An input that could not be read would be missed here once more.
        if names().any(|name| name == input) || self.diagnostics.has_errors() {
            return;
        }
        let help = match names().next() {
            None => "write the state itself, such as `state: DisplayLinear`".to_owned(),
            Some(_) => format!("there is {}", list(names(), 8)),
        };
        let message = format!("{} is not a required image input", quote(input));
        let diagnostic = Diagnostic::error("unknown-name", message).at(location, "").help(help);
        self.diagnostics.push(diagnostic.did_you_mean(input, names()));
    }

    pub(super) fn size(&mut self) -> Option<SizeRule> {
        const RULES: [(&str, SizeRule); 3] =
            [("Same", SizeRule::Same), ("Half", SizeRule::Half), ("Double", SizeRule::Double)];
        let Some(item) = self.take("size") else { return Some(SizeRule::Same) };
        match &item.value {
            Tree::Name(name) => {
                one_of(&Spanned::new(name.clone(), item.location.clone()), "size", RULES, self.diagnostics)
            }
            Tree::Tuple(Some(word), items) if word.value == "Fixed" => match items.as_slice() {
                [
                    Item { value: Tree::Int(width @ 1..=16384), .. },
                    Item { value: Tree::Int(height @ 1..=16384), .. },
                ] => Some(SizeRule::Fixed(*width as u32, *height as u32)),
                _ => {
                    self.wrong("size", &item, "`Fixed(width, height)` with sides of 1 to 16384");
                    None
                }
            },
            _ => {
                self.wrong("size", &item, "`Same`, `Half`, `Double` or `Fixed(width, height)`");
                None
            }
        }
    }

    pub(super) fn value(&mut self, name: &str, ty: Type, is_required: bool) -> Option<Value> {
        let item = if is_required { self.required(name)? } else { self.take(name)? };
        let value = item.value.value(ty);
        if value.is_none() {
            self.wrong(name, &item, &ty.describe());
        }
        value
    }

    pub(super) fn range(&mut self, name: &str, is_required: bool) -> Option<(f64, f64)> {
        let item = if is_required { self.required(name)? } else { self.take(name)? };
        let range = match &item.value {
            Tree::Tuple(None, ends) => match ends.as_slice() {
                [low, high] => low.value.number().zip(high.value.number()).filter(|(low, high)| low <= high),
                _ => None,
            },
            _ => None,
        };
        if range.is_none() {
            self.wrong(name, &item, "the least and the greatest number in parentheses, `(0.0, 1.0)`");
        }
        range
    }

    pub(super) fn finish(self, known: &[&str]) {
        for (name, _) in &self.left {
            let message = format!("{} has no field {}", self.what, quote(&name.value));
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "");
            let diagnostic = diagnostic.help(format!("its fields are {}", list(known.iter().copied(), known.len())));
            self.diagnostics.push(diagnostic.did_you_mean(&name.value, known.iter().copied()));
        }
    }
}

impl Tree {
    /// The value of a number, a flag or a vector that a parameter of this type gets.
    pub(super) fn value(&self, ty: Type) -> Option<Value> {
        match (ty, self) {
            (Type::Bool, Self::Bool(flag)) => Some(Value::Bool(*flag)),
            (Type::Int, Self::Int(whole)) => Some(Value::Int(*whole)),
            (Type::Float, _) => self.number().map(Value::Float),
            (Type::Vector(n), Self::Tuple(None, items)) if items.len() == n => {
                let mut numbers = [0.0; 4];
                for (slot, item) in numbers.iter_mut().zip(items) {
                    *slot = item.value.number()?;
                }
                Some(Value::Vector(numbers, n))
            }
            _ => None,
        }
    }
}

/// Returns whether a text can be printed: it is not empty, and has no control characters but line feeds and tabs.
fn is_shown(text: &str) -> bool {
    !text.trim().is_empty() && text.chars().all(|c| !is_control(c) || matches!(c, '\n' | '\r' | '\t'))
}
