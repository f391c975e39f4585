//! SampleMode a `node.ron`.

use super::{Declaration, DeclaredOutput, SizeRule};
use crate::document::{Field, Group, Item, Tree, doubled, present_name, renamed};
use crate::node::contract::snake;
use crate::node::{Fallback, Input, Output, OutputState, PortType};
use afterimage_base::Shared;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Place, Spanned, did_you_mean, list, quote};
use afterimage_base::image::ColorState;
use afterimage_base::value::{Param, Type, Value};

const SHAPE: &str =
    "a node file is `Kind(name: \"...\", doc: \"...\", inputs: { ... }, outputs: { ... }, parameters: { ... })`";

/// What the file declares; `None` once it is clear that no kind can come of it.
pub(super) fn declaration(tree: Item, diagnostics: &mut Diagnostics) -> Option<Declaration> {
    let mut fields = match tree.value {
        Tree::Struct(Some(word), fields) if word.value == "Kind" => {
            Fields::new(word.place, "a node file", fields, diagnostics)
        }
        Tree::Broken => return None,
        other => {
            let message = format!("the file holds {}, not a `Kind`", other.describe());
            diagnostics.push(Diagnostic::error("not-a-kind", message).at(&tree.place.part(0..1), "").help(SHAPE));
            return None;
        }
    };
    let name = fields.text("name");
    let doc = fields.text("doc");
    let inputs: Vec<_> =
        fields.map("inputs").into_iter().filter_map(|(name, item)| input(&name, item, fields.diagnostics)).collect();
    let function = name.as_ref().map(|name| Spanned::new(snake(&name.value), name.place.clone()));
    let outputs = match (fields.map("outputs"), function) {
        (outputs, Some(function)) => outputs
            .into_iter()
            .filter_map(|(name, item)| output(&name, item, &function, &inputs, fields.diagnostics))
            .collect(),
        _ => Vec::new(),
    };
    let params = match fields.take("parameters") {
        Some(item) => fields.entries("parameters", item),
        None => Vec::new(),
    };
    let params = params.into_iter().filter_map(|(name, item)| parameter(&name, item, fields.diagnostics)).collect();
    let fallback = fields.take("fallback");
    let fallback = fallback_of(fallback, &inputs, fields.diagnostics);
    fields.finish(&["name", "doc", "inputs", "outputs", "parameters", "fallback"]);
    Some(Declaration { name: name?, doc: doc?.value, inputs, outputs, params, fallback })
}

fn fallback_of(item: Option<Item>, inputs: &[(Input, Place)], diagnostics: &mut Diagnostics) -> Fallback {
    let images = || inputs.iter().filter(|(port, _)| port.ty == PortType::Image).map(|(port, _)| &*port.name);
    let Some(item) = item else {
        return images().next().map_or(Fallback::Zero, |name| Fallback::Input(name.to_owned().into()));
    };
    match &item.value {
        Tree::Name(name) if name == "Zero" => Fallback::Zero,
        Tree::Name(name) if name == "Absent" => Fallback::Absent,
        Tree::Text(name) if images().any(|port| port == name) => Fallback::Input(name.clone().into()),
        _ => {
            let help = format!("write `Zero`, `Absent` or one of the image inputs in quotes: {}", list(images(), 8));
            diagnostics.push(
                Diagnostic::error("wrong-type", "`fallback` is no fallback of a node").at(&item.place, "").help(help),
            );
            Fallback::Zero
        }
    }
}

/// The name and the fields of `Type(...)`.
fn typed(
    name: &Spanned<String>,
    item: Item,
    what: &str,
    diagnostics: &mut Diagnostics,
) -> Option<(Spanned<String>, Group<Field>)> {
    match item.value {
        Tree::Struct(Some(ty), fields) => Some((ty, fields)),
        Tree::Name(ty) => Some((Spanned::new(ty, item.place), Group::default())),
        Tree::Broken => None,
        other => {
            let message = format!("the {what} {} has {} for a type", quote(&name.value), other.describe());
            diagnostics.push(
                Diagnostic::error("wrong-shape", message)
                    .at(&item.place, "")
                    .help("write it as `\"name\": Type(doc: \"...\")`"),
            );
            None
        }
    }
}

/// The one of some named things that a name means.
fn one_of<T: Copy, const N: usize>(
    ty: &Spanned<String>,
    what: &str,
    known: [(&'static str, T); N],
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    let found = known.iter().find(|(name, _)| *name == ty.value).map(|(_, value)| *value);
    if found.is_none() {
        let names = known.map(|(name, _)| name);
        let diagnostic =
            Diagnostic::error("unknown-type", format!("no {what} is called {}", quote(&ty.value))).at(&ty.place, "");
        let help = format!("there are {}", list(names, N));
        diagnostics.push(diagnostic.help(help).maybe_help(did_you_mean(&ty.value, names)));
    }
    found
}

const STATES: [(&str, ColorState); 6] = [
    ("Scene", ColorState::Scene),
    ("Exposed", ColorState::Exposed),
    ("LogLuminance", ColorState::LogLuminance),
    ("DisplayLinear", ColorState::DisplayLinear),
    ("Encoded", ColorState::Encoded),
    ("Data", ColorState::Data),
];

fn input(name: &Spanned<String>, item: Item, diagnostics: &mut Diagnostics) -> Option<(Input, Place)> {
    const TYPES: [(&str, PortType); 3] =
        [("Image", PortType::Image), ("Volume", PortType::Volume), ("Value", PortType::Value)];
    let (ty, fields) = typed(name, item, "input", diagnostics)?;
    let port = one_of(&ty, "type of input", TYPES, diagnostics);
    let mut fields = Fields::new(ty.place, "an input", fields, diagnostics);
    let doc = fields.text("doc");
    let optional = fields.flag("optional");
    let states = fields.accepted();
    fields.finish(&["doc", "optional", "accepts"]);
    let input =
        Input { name: name.value.clone().into(), ty: port?, states: states.into(), optional, doc: doc?.value.into() };
    Some((input, name.place.clone()))
}

fn output(
    name: &Spanned<String>,
    item: Item,
    otherwise: &Spanned<String>,
    inputs: &[(Input, Place)],
    diagnostics: &mut Diagnostics,
) -> Option<DeclaredOutput> {
    let (ty, fields) = typed(name, item, "output", diagnostics)?;
    let image = one_of(&ty, "type of output", [("Image", PortType::Image)], diagnostics);
    let mut fields = Fields::new(ty.place, "an output", fields, diagnostics);
    let doc = fields.text("doc");
    let state = fields.output_state(inputs);
    let function = if fields.has("function") { fields.text("function") } else { Some(otherwise.clone()) };
    let size = fields.size();
    fields.finish(&["doc", "state", "function", "size"]);
    let port = Output { name: name.value.clone().into(), ty: image?, state: state?, doc: doc?.value.into() };
    Some(DeclaredOutput { port, function: function?, size: size? })
}

fn parameter(name: &Spanned<String>, item: Item, diagnostics: &mut Diagnostics) -> Option<(Param, Place)> {
    const TYPES: [(&str, Type); 6] = [
        ("Bool", Type::Bool),
        ("Int", Type::Int),
        ("Float", Type::Float),
        ("Vector2", Type::Vector(2)),
        ("Vector3", Type::Vector(3)),
        ("Vector4", Type::Vector(4)),
    ];
    let (word, fields) = typed(name, item, "parameter", diagnostics)?;
    let ty = one_of(&word, "type of parameter", TYPES, diagnostics);
    let mut fields = Fields::new(word.place, "a parameter", fields, diagnostics);
    let doc = fields.text("doc");
    let default = fields.value("default", ty?, true);
    let neutral = fields.value("neutral", ty?, false);
    let within = fields.range("within", ty? != Type::Bool);
    let usually = fields.range("usually", false);
    let unit = if fields.has("unit") { fields.text("unit") } else { None };
    fields.finish(&["doc", "default", "neutral", "within", "usually", "unit"]);
    // The numbers of a folder kind are uniforms: no change of theirs needs a new plan.
    let mut param = Param::new(name.value.clone(), &doc?.value, ty?, default?).live();
    param.domain = within;
    param.usual = usually;
    param.neutral = neutral;
    param.unit = unit.map_or(Shared::of(""), |unit| unit.value.into());
    for (what, value) in [("default", Some(&param.default)), ("neutral", param.neutral.as_ref())] {
        if let Some(Err(why)) = value.map(|value| param.accepts(value)) {
            let message = format!("{} of {} is not acceptable: {why}", quote(what), quote(&name.value));
            diagnostics.push(Diagnostic::error("out-of-domain", message).at(&name.place, ""));
        }
    }
    Some((param, name.place.clone()))
}

/// The fields of a thing, taken one by one; what is left in the end is a mistake.
struct Fields<'d> {
    place: Place,
    what: &'static str,
    left: Vec<Field>,
    /// Whether fields are missing because of errors that have been reported.
    is_partial: bool,
    diagnostics: &'d mut Diagnostics,
}

impl<'d> Fields<'d> {
    fn new(place: Place, what: &'static str, fields: Group<Field>, diagnostics: &'d mut Diagnostics) -> Self {
        let mut left: Vec<Field> = Vec::new();
        for (mut name, item) in fields.entries {
            if let Some(present) = present_name(what, &name.value) {
                diagnostics.push(renamed(&name, present));
                name.value = present.to_owned();
            }
            match left.iter().find(|(known, _)| known.value == name.value) {
                Some((first, _)) => diagnostics.push(doubled(&name, &first.place, "field")),
                None => left.push((name, item)),
            }
        }
        Self { place, what, left, is_partial: fields.is_partial, diagnostics }
    }

    fn has(&self, name: &str) -> bool {
        self.left.iter().any(|(field, _)| field.value == name)
    }

    fn take(&mut self, name: &str) -> Option<Item> {
        let at = self.left.iter().position(|(field, _)| field.value == name)?;
        Some(self.left.remove(at).1)
    }

    fn required(&mut self, name: &str) -> Option<Item> {
        let item = self.take(name);
        if item.is_none() && !self.is_partial {
            let message = format!("{} needs {}", self.what, quote(name));
            self.diagnostics.push(Diagnostic::error("missing-field", message).at(&self.place, ""));
        }
        item
    }

    fn wrong(&mut self, name: &str, item: &Item, wanted: &str) {
        if item.value.is_broken() {
            return;
        }
        let message = format!("{} is {wanted}", quote(name));
        let seen = format!("this is {}", item.value.describe());
        self.diagnostics.push(Diagnostic::error("wrong-type", message).at(&item.place, seen));
    }

    fn text(&mut self, name: &str) -> Option<Spanned<String>> {
        let item = self.required(name)?;
        match &item.value {
            Tree::Text(text) if !text.trim().is_empty() => Some(Spanned::new(text.clone(), item.place)),
            _ => {
                self.wrong(name, &item, "a text in quotes that is not empty");
                None
            }
        }
    }

    fn flag(&mut self, name: &str) -> bool {
        match self.take(name) {
            Some(Item { value: Tree::Bool(flag), .. }) => flag,
            Some(item) => {
                self.wrong(name, &item, "`true` or `false`");
                false
            }
            None => false,
        }
    }

    fn map(&mut self, name: &str) -> Vec<(Spanned<String>, Item)> {
        self.required(name).map_or_else(Vec::new, |item| self.entries(name, item))
    }

    fn entries(&mut self, name: &str, item: Item) -> Vec<(Spanned<String>, Item)> {
        let Tree::Map(group) = item.value else {
            self.wrong(name, &item, "a map, `{ \"name\": Type(...) }`");
            return Vec::new();
        };
        let mut named: Vec<(Spanned<String>, Item)> = Vec::new();
        for (key, value) in group.entries {
            match key.value {
                Tree::Text(text) => {
                    let key = Spanned::new(text, key.place);
                    match named.iter().find(|(known, _)| known.value == key.value) {
                        Some((first, _)) => self.diagnostics.push(doubled(&key, &first.place, "name")),
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

    fn accepted(&mut self) -> Vec<ColorState> {
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

    fn state(&mut self, item: Item) -> Option<ColorState> {
        match item.value {
            Tree::Name(name) => one_of(&Spanned::new(name, item.place), "image state", STATES, self.diagnostics),
            _ => {
                self.wrong("state", &item, "the bare name of an image state");
                None
            }
        }
    }

    fn output_state(&mut self, inputs: &[(Input, Place)]) -> Option<OutputState> {
        let item = self.required("state")?;
        match &item.value {
            Tree::Name(_) => self.state(item).map(OutputState::Always),
            Tree::Tuple(Some(word), items) if word.value == "Same" => match items.as_slice() {
                [Item { value: Tree::Text(input), place }] => {
                    self.is_required_image(input, place, inputs);
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
    fn is_required_image(&mut self, input: &str, place: &Place, inputs: &[(Input, Place)]) {
        let fits = |port: &&Input| port.ty == PortType::Image && !port.optional;
        let names = || inputs.iter().map(|(port, _)| port).filter(fits).map(|port| &*port.name);
        // An input that could not be read would be missed here once more.
        if names().any(|name| name == input) || self.diagnostics.has_errors() {
            return;
        }
        let help = match names().next() {
            None => "write the state itself, such as `state: DisplayLinear`".to_owned(),
            Some(_) => format!("there is {}", list(names(), 8)),
        };
        let message = format!("{} is no image input that must be wired", quote(input));
        let diagnostic = Diagnostic::error("unknown-name", message).at(place, "").help(help);
        self.diagnostics.push(diagnostic.maybe_help(did_you_mean(input, names())));
    }

    fn size(&mut self) -> Option<SizeRule> {
        const RULES: [(&str, SizeRule); 3] =
            [("Same", SizeRule::Same), ("Half", SizeRule::Half), ("Double", SizeRule::Double)];
        let Some(item) = self.take("size") else { return Some(SizeRule::Same) };
        match &item.value {
            Tree::Name(name) => {
                one_of(&Spanned::new(name.clone(), item.place.clone()), "size", RULES, self.diagnostics)
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

    fn value(&mut self, name: &str, ty: Type, is_required: bool) -> Option<Value> {
        let item = if is_required { self.required(name)? } else { self.take(name)? };
        let value = match (ty, &item.value) {
            (Type::Bool, Tree::Bool(flag)) => Some(Value::Bool(*flag)),
            (Type::Int, Tree::Int(whole)) => Some(Value::Int(*whole)),
            (Type::Float, _) => number(&item).map(Value::Float),
            (Type::Vector(n), Tree::Tuple(None, items)) if items.len() == n => vector(items),
            _ => None,
        };
        if value.is_none() {
            self.wrong(name, &item, &ty.describe());
        }
        value
    }

    fn range(&mut self, name: &str, is_required: bool) -> Option<(f64, f64)> {
        let item = if is_required { self.required(name)? } else { self.take(name)? };
        let range = match &item.value {
            Tree::Tuple(None, ends) => match ends.as_slice() {
                [low, high] => number(low).zip(number(high)).filter(|(low, high)| low <= high),
                _ => None,
            },
            _ => None,
        };
        if range.is_none() {
            self.wrong(name, &item, "the least and the greatest number in parentheses, `(0.0, 1.0)`");
        }
        range
    }

    fn finish(self, known: &[&str]) {
        for (name, _) in &self.left {
            let message = format!("{} has no field {}", self.what, quote(&name.value));
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.place, "");
            let diagnostic = diagnostic.help(format!("its fields are {}", list(known.iter().copied(), known.len())));
            self.diagnostics.push(diagnostic.maybe_help(did_you_mean(&name.value, known.iter().copied())));
        }
    }
}

fn number(item: &Item) -> Option<f64> {
    match item.value {
        Tree::Int(whole) => Some(whole as f64),
        Tree::Float(number) => Some(number),
        _ => None,
    }
}

fn vector(items: &[Item]) -> Option<Value> {
    let mut numbers = [0.0; 4];
    for (slot, item) in numbers.iter_mut().zip(items) {
        *slot = number(item)?;
    }
    Some(Value::Vector(numbers, items.len()))
}
