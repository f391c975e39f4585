//! Reads a `node.ron`.

use super::declaration::{Declaration, Made};
use super::fields::{Fields, one_of};
use super::images;
use super::ports::typed;
use crate::document::{Item, Tree};
use crate::node::contract::snake;
use crate::node::{CAMERA, Input, PortType};
use afterimage_base::Shared;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, quote};
use afterimage_base::value::{Param, Type, Value, When};

const EXPECTED_FORM: &str =
    "a node file is `Kind(name: \"...\", doc: \"...\", inputs: { ... }, outputs: { ... }, parameters: { ... })`";

/// Reads the declaration; `None` if no kind can be made of it.
pub(super) fn declaration(tree: Item, diagnostics: &mut Diagnostics) -> Option<Declaration> {
    let mut fields = match tree.value {
        Tree::Struct(Some(word), fields) if word.value == "Kind" => {
            Fields::new(word.location, "a node file", fields, diagnostics)
        }
        Tree::Broken => return None,
        other => {
            let message = format!("the file holds {}, not a `Kind`", other.describe());
            diagnostics
                .push(Diagnostic::error("not-a-kind", message).at(&tree.location.part(0..1), "").help(EXPECTED_FORM));
            return None;
        }
    };
    let name = fields.text("name");
    let doc = fields.text("doc");
    let inputs: Vec<_> =
        fields.map("inputs").into_iter().filter_map(|(name, item)| input(&name, item, fields.diagnostics)).collect();
    let made = name.as_ref().map(|name| made(name, &mut fields, &inputs)).unwrap_or_default();
    let params = match fields.take("parameters") {
        Some(item) => fields.entries("parameters", item),
        None => Vec::new(),
    };
    let params = params.into_iter().filter_map(|(name, item)| parameter(&name, item, fields.diagnostics)).collect();
    let params = with_conditions(params, &inputs, fields.diagnostics);
    let of_color = fields.flag("of_color");
    fields.finish(&["name", "doc", "inputs", "images", "outputs", "parameters", "of_color"]);
    Some(Declaration { name: name?, doc: doc?.value, inputs, made, params, of_color })
}

/// The images and the outputs.
fn made(kind: &Spanned<String>, fields: &mut Fields<'_>, inputs: &[(Input, Location)]) -> Vec<Made> {
    let snake = snake(&kind.value);
    let images = match fields.take("images") {
        Some(item) => fields.entries("images", item),
        None => Vec::new(),
    };
    let images = images.into_iter().filter_map(|(name, item)| images::image(name, item, &snake, fields.diagnostics));
    let mut made: Vec<Made> = images.collect();
    let function = Spanned::new(snake, kind.location.clone());
    for (at, (name, item)) in fields.map("outputs").into_iter().enumerate() {
        made.extend(images::output(name, item, at == 0, &function, inputs, fields.diagnostics));
    }
    images::check_distinct(inputs, &made, fields.diagnostics);
    made
}

fn input(name: &Spanned<String>, item: Item, diagnostics: &mut Diagnostics) -> Option<(Input, Location)> {
    let plain = |ty: PortType| (ty.name(), (ty, None));
    let types = [
        plain(PortType::Image),
        plain(PortType::Pyramid),
        plain(PortType::Volume),
        plain(PortType::Table),
        plain(PortType::Value),
        (CAMERA.name, (PortType::Block, Some(&CAMERA))),
    ];
    let (ty, fields) = typed(name, item, "input", diagnostics)?;
    let port = one_of(&ty, "type of input", types, diagnostics);
    let mut fields = Fields::new(ty.location, "an input", fields, diagnostics);
    let doc = fields.text("doc");
    let (port, block) = port.unzip();
    // A function cannot take a block that is not there.
    let may_be_absent = block.flatten().is_none();
    let optional = may_be_absent && fields.flag("optional");
    let states = fields.accepted();
    let content = if fields.has("content") { fields.text("content") } else { None };
    let known: &[&str] = if may_be_absent { &["doc", "optional", "accepts", "content"] } else { &["doc"] };
    fields.finish(known);
    let content = content.map(|content| content.value.into());
    let (states, doc) = (states.into(), doc?.value.into());
    let input = Input {
        name: name.value.clone().into(),
        ty: port?,
        states,
        optional,
        only_x: false,
        content,
        block: block?,
        doc,
    };
    Some((input, name.location.clone()))
}

/// A parameter with its conditions as they are written: whether each is one of `when`, its subject and its values.
struct ReadParameter {
    param: Param,
    location: Location,
    conditions: Vec<(bool, Spanned<String>, Item)>,
}

fn parameter(name: &Spanned<String>, item: Item, diagnostics: &mut Diagnostics) -> Option<ReadParameter> {
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
    let mut fields = Fields::new(word.location, "a parameter", fields, diagnostics);
    let doc = fields.text("doc");
    let default = fields.value("default", ty?, true);
    let neutral = fields.value("neutral", ty?, false);
    let within = fields.range("within", ty? != Type::Bool);
    let usually = fields.range("usually", false);
    let logarithmic = fields.flag("logarithmic");
    let unit = if fields.has("unit") { fields.text("unit") } else { None };
    let mut conditions = Vec::new();
    for (word, is_one_of) in [("when", true), ("unless", false)] {
        let entries = fields.take(word).map(|item| fields.entries(word, item)).unwrap_or_default();
        conditions.extend(entries.into_iter().map(|(subject, values)| (is_one_of, subject, values)));
    }
    fields.finish(&["doc", "default", "neutral", "within", "usually", "logarithmic", "unit", "when", "unless"]);
    // The numbers of a folder kind are uniforms: no change of theirs needs a new plan.
    let mut param = Param::new(name.value.clone(), &doc?.value, ty?, default?).live();
    param.domain = within;
    (param.usual, param.logarithmic) = (usually, logarithmic);
    param.neutral = neutral;
    param.unit = unit.map_or(Shared::of(""), |unit| unit.value.into());
    for (what, value) in [("default", Some(&param.default)), ("neutral", param.neutral.as_ref())] {
        if let Some(Err(why)) = value.map(|value| param.accepts(value)) {
            let message = format!("{} of {} is not acceptable: {why}", quote(what), quote(&name.value));
            diagnostics.push(Diagnostic::error("out-of-domain", message).at(&name.location, ""));
        }
    }
    Some(ReadParameter { param, location: name.location.clone(), conditions })
}

/// The parameters with their conditions, whose values have the types of the parameters that they name.
fn with_conditions(
    read: Vec<ReadParameter>,
    inputs: &[(Input, Location)],
    diagnostics: &mut Diagnostics,
) -> Vec<(Param, Location)> {
    let params: Vec<(Shared<str>, Type)> = read.iter().map(|read| (read.param.name.clone(), read.param.ty)).collect();
    let optional: Vec<&Input> = inputs.iter().map(|(input, _)| input).filter(|input| input.optional).collect();
    let with_conditions = |ReadParameter { mut param, location, conditions }| {
        for (is_one_of, name, item) in conditions {
            let ty = params.iter().find(|(known, _)| *known == name.value).map(|(_, ty)| *ty);
            if ty.is_none() && !optional.iter().any(|input| input.name == name.value) {
                let known =
                    || params.iter().map(|(known, _)| &**known).chain(optional.iter().map(|input| &*input.name));
                let message = format!("{} is neither a parameter nor an optional input", quote(&name.value));
                let error = Diagnostic::error("unknown-name", message).at(&name.location, "");
                diagnostics.push(error.did_you_mean(&name.value, known()));
                continue;
            }
            let values: Option<Vec<Value>> = match &item.value {
                Tree::List(items) => items.iter().map(|item| item.value.value(ty.unwrap_or(Type::Bool))).collect(),
                value => value.value(ty.unwrap_or(Type::Bool)).map(|value| vec![value]),
            };
            let name: Shared<str> = name.value.into();
            param.when.push(match (ty, values) {
                (Some(_), Some(values)) if is_one_of => When::OneOf(name, values),
                (Some(_), Some(values)) => When::NoneOf(name, values),
                (None, Some(flags)) => When::Wired(name, flags.contains(&Value::Bool(is_one_of))),
                (ty, None) => {
                    let expected = ty.map_or("`true` or `false`: whether it is wired".into(), Type::describe);
                    let seen = format!("this is {}", item.value.describe());
                    let error = Diagnostic::error("wrong-type", format!("the condition is {expected}"));
                    diagnostics.push(error.at(&item.location, seen));
                    continue;
                }
            });
        }
        (param, location)
    };
    read.into_iter().map(with_conditions).collect()
}
