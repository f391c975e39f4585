//! Reads what functions make: the images and the outputs of a `node.ron`.

use super::declaration::{Made, Read, Shape, SizeRule};
use super::fields::{Fields, one_of};
use super::ports::{fallback_of, typed};
use crate::document::{Item, Tree, doubled};
use crate::node::contract::is_snake;
use crate::node::{Input, Output, PortType};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, quote};
use afterimage_base::image::Format;
use afterimage_wgsl::limits::INVOCATIONS;

const TYPES: [(&str, PortType); 2] = [("Image", PortType::Image), ("Pyramid", PortType::Pyramid)];

/// An image between the inputs and the outputs. Its function is named after the kind and the image.
pub(super) fn image(name: Spanned<String>, item: Item, kind: &str, diagnostics: &mut Diagnostics) -> Option<Made> {
    check_name(&name, diagnostics);
    let (ty, fields) = typed(&name, item, "image", diagnostics)?;
    let type_of = one_of(&ty, "type of image", TYPES, diagnostics)?;
    let mut fields = Fields::new(ty.location, "an image", fields, diagnostics);
    let otherwise = Spanned::new(format!("{kind}_{}", name.value), name.location.clone());
    let function = function(&mut fields, &otherwise);
    let reads = reads(&mut fields);
    let shape = shape(&mut fields, type_of);
    let format = format(&mut fields);
    fields.finish(&known(&["function", "format", "reads"], type_of, shape.as_ref()));
    let (shape, size) = shape?;
    Some(Made { name, function: function?, shape, size, format: format?, reads, port: None })
}

/// An output port and how it is made. The first output may leave out its function, which is then named after the kind:
/// another output that did so would be a copy.
pub(super) fn output(
    name: Spanned<String>,
    item: Item,
    is_main: bool,
    otherwise: &Spanned<String>,
    inputs: &[(Input, Location)],
    diagnostics: &mut Diagnostics,
) -> Option<Made> {
    let (ty, fields) = typed(&name, item, "output", diagnostics)?;
    let type_of = one_of(&ty, "type of output", TYPES, diagnostics)?;
    let what = if is_main { "an output" } else { "an output after the first" };
    let mut fields = Fields::new(ty.location, what, fields, diagnostics);
    let doc = fields.text("doc");
    let state = fields.output_state(inputs);
    let function = if is_main { function(&mut fields, otherwise) } else { fields.text("function") };
    let reads = reads(&mut fields);
    let shape = shape(&mut fields, type_of);
    let fallback = fields.take("fallback");
    let fallback = fallback_of(fallback, type_of, is_main, inputs, fields.diagnostics);
    fields.finish(&known(&["doc", "state", "function", "reads", "fallback"], type_of, shape.as_ref()));
    let port = name.value.clone().into();
    let port = Output { name: port, ty: type_of, state: state?, doc: doc?.value.into(), fallback, content: None };
    let (shape, size) = shape?;
    Some(Made { name, function: function?, shape, size, format: Format::Rgba16Float, reads, port: Some(port) })
}

/// Other names are checked by the contract of kinds.
fn check_name(name: &Spanned<String>, diagnostics: &mut Diagnostics) {
    if !is_snake(&name.value) {
        let message = format!("{} is not a valid name of an image", quote(&name.value));
        let help = "names are in snake_case, as the arguments of functions are";
        diagnostics.push(Diagnostic::error("bad-name", message).at(&name.location, "").help(help));
    }
}

fn function(fields: &mut Fields<'_>, otherwise: &Spanned<String>) -> Option<Spanned<String>> {
    if fields.has("function") { fields.text("function") } else { Some(otherwise.clone()) }
}

/// For what the function is called, and the size that follows.
fn shape(fields: &mut Fields<'_>, ty: PortType) -> Option<(Shape, SizeRule)> {
    let shape = match ty {
        PortType::Image if !fields.has("up") => {
            let workgroup = if fields.has("workgroup") { Some(workgroup(fields)?) } else { None };
            return Some((Shape::Image { workgroup }, fields.size()?));
        }
        PortType::Image => Shape::Up { of: fields.text("up")? },
        _ if fields.has("each") => Shape::Each { of: fields.text("each")? },
        _ => {
            let (of, levels) = (fields.text("down"), levels(fields));
            Shape::Down { of: of?, levels: levels? }
        }
    };
    Some((shape, SizeRule::Same))
}

/// The invocations of a workgroup, across and down.
fn workgroup(fields: &mut Fields<'_>) -> Option<[u32; 2]> {
    let item = fields.required("workgroup")?;
    let sides = match &item.value {
        Tree::Tuple(None, sides) => match sides.as_slice() {
            [Item { value: Tree::Int(width @ 1..), .. }, Item { value: Tree::Int(height @ 1..), .. }] => {
                Some((*width, *height))
            }
            _ => None,
        },
        _ => None,
    };
    let Some((width, height)) = sides else {
        fields.wrong("workgroup", &item, "the invocations across and down, `(16, 16)`");
        return None;
    };
    if let Some(message) = INVOCATIONS.exceeded(usize::try_from(width.saturating_mul(height)).unwrap_or(usize::MAX)) {
        fields.diagnostics.push(Diagnostic::error("limit", message).at(&item.location, ""));
        return None;
    }
    Some([width as u32, height as u32])
}

/// The fields that such a thing has.
fn known<'f>(of_all: &[&'f str], ty: PortType, shape: Option<&(Shape, SizeRule)>) -> Vec<&'f str> {
    let own: &[&str] = match (ty, shape) {
        (_, Some((Shape::Up { .. }, _))) => &["up"],
        (PortType::Image, _) => &["size", "up", "workgroup"],
        (_, Some((Shape::Each { .. }, _))) => &["each"],
        _ => &["down", "levels", "each"],
    };
    of_all.iter().chain(own).copied().collect()
}

/// The most levels of a pyramid: an image of 16384 pixels has 14.
const MAX_LEVELS: i64 = 16;

fn levels(fields: &mut Fields<'_>) -> Option<u32> {
    let item = fields.required("levels")?;
    match item.value {
        Tree::Int(levels @ 1..=MAX_LEVELS) => Some(levels as u32),
        _ => {
            fields.wrong("levels", &item, "a whole number from 1 to 16");
            None
        }
    }
}

fn format(fields: &mut Fields<'_>) -> Option<Format> {
    let Some(item) = fields.take("format") else { return Some(Format::Rgba16Float) };
    match &item.value {
        Tree::Name(name) => {
            let named = Spanned::new(name.clone(), item.location.clone());
            one_of(&named, "format", Format::ALL.map(|format| (format.name(), format)), fields.diagnostics)
        }
        _ => {
            fields.wrong("format", &item, "the bare name of a format");
            None
        }
    }
}

fn reads(fields: &mut Fields<'_>) -> Vec<(Spanned<String>, Read)> {
    let Some(item) = fields.take("reads") else { return Vec::new() };
    let entries = fields.entries("reads", item);
    entries.into_iter().filter_map(|(argument, item)| Some((argument, read(fields, item)?))).collect()
}

fn read(fields: &mut Fields<'_>, item: Item) -> Option<Read> {
    match &item.value {
        Tree::Text(of) => return Some(Read { of: Spanned::new(of.clone(), item.location), level: None }),
        Tree::Tuple(Some(word), items) if word.value == "Level" => {
            if let [Item { value: Tree::Text(of), location }, Item { value: Tree::Int(level @ 0..MAX_LEVELS), .. }] =
                items.as_slice()
            {
                let of = Spanned::new(of.clone(), location.clone());
                return Some(Read { of, level: Some(*level as u32) });
            }
        }
        _ => {}
    }
    fields.wrong("reads", &item, "a map of names, `{ \"wide\": \"across\" }`, and of levels, `Level(\"levels\", 3)`");
    None
}

/// Reports images with a name that an input, an output or another image has.
pub(super) fn check_distinct(inputs: &[(Input, Location)], made: &[Made], diagnostics: &mut Diagnostics) {
    let (images, outputs): (Vec<&Made>, Vec<&Made>) = made.iter().partition(|made| made.port.is_none());
    for image in images {
        let name = &image.name.value;
        let input = inputs.iter().find(|(port, _)| port.name == *name).map(|(_, location)| location);
        let output = outputs.iter().find(|output| output.name.value == *name).map(|output| &output.name.location);
        if let Some(other) = input.or(output) {
            diagnostics.push(doubled(&image.name, other, "name"));
        }
    }
}
