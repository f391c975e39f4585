//! What a kind declares: names, manual, ports, parameters.

use std::collections::BTreeSet;

use super::complaints::Violations;
use super::names::{RESERVED, is_free_in_wgsl, is_pascal, is_snake};
use crate::node::{Fallback, Input, NodeKind, Output, OutputState, PortType};
use afterimage_base::value::{Param, Type, Value};

/// Names that pipeline files and shaders use for other things.
const TAKEN: [&str; 6] = ["when", "format", "label", "at", "frame", "params"];

pub(super) fn look(kind: &NodeKind, complaints: &mut Violations) {
    complaints.require(is_pascal(kind.name()), || "the name is not in PascalCase".into());
    complaints.require(!RESERVED.contains(&kind.name()), || "pipeline files use this name themselves".into());
    complaints.require(!kind.doc().trim().is_empty(), || "there is no doc".into());
    names(kind, complaints);
    kind.inputs().iter().for_each(|port| input(port, complaints));
    complaints.require(!kind.outputs().is_empty(), || "there is no output".into());
    kind.outputs().iter().for_each(|port| output(kind, port, complaints));
    kind.outputs().iter().for_each(|port| fallback(kind, port, complaints));
    kind.params().iter().for_each(|param| parameter(param, complaints));
}

fn names(kind: &NodeKind, complaints: &mut Violations) {
    let inputs = kind.inputs().iter().map(|port| &*port.name);
    let params = kind.params().iter().map(|param| &*param.name);
    distinct(inputs.chain(params), complaints);
    distinct(kind.outputs().iter().map(|port| &*port.name), complaints);
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>, complaints: &mut Violations) {
    let mut seen = BTreeSet::new();
    for name in names {
        complaints.require(seen.insert(name), || format!("the name `{name}` is given twice"));
        complaints.require(is_snake(name), || format!("the name `{name}` is not in snake_case"));
        complaints.require(!TAKEN.contains(&name), || {
            format!("`{name}` means something else in every pipeline file or shader")
        });
    }
}

fn is_image(ty: PortType) -> bool {
    matches!(ty, PortType::Image | PortType::Multisampled | PortType::Pyramid)
}

fn is_number(ty: PortType) -> bool {
    matches!(ty, PortType::Table | PortType::Value | PortType::Block)
}

/// Ports are arguments and bindings of shaders. Parameters need not be: a number that stays on the CPU may have any
/// name, and one that goes into a uniform is seen by naga.
fn port_name(name: &str, complaints: &mut Violations) {
    complaints
        .require(is_free_in_wgsl(name), || format!("`{name}` is a word of WGSL and cannot be the name of a port"));
}

fn input(port: &Input, complaints: &mut Violations) {
    let name = &*port.name;
    port_name(name, complaints);
    complaints.require(!port.doc.trim().is_empty(), || format!("the input `{name}` has no doc"));
    complaints.require(!is_number(port.ty) || port.states.is_empty(), || {
        format!("the input `{name}` is a {} and has no image state", port.ty.name())
    });
    complaints.require((port.ty == PortType::Block) == port.block.is_some(), || {
        format!("the input `{name}` is a block without a declaration, or has one and is none: use `Input::block`")
    });
    content(name, port.ty, port.content.as_deref(), complaints);
}

/// Images and pyramids have a color state, which says what their numbers are.
fn content(port: &str, ty: PortType, content: Option<&str>, complaints: &mut Violations) {
    complaints.require(content.is_none() || !is_image(ty), || {
        format!("`{port}` is a {} and has no content but its color state", ty.name())
    });
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    complaints.require(content.is_none_or(|name| !name.is_empty() && name.chars().all(is_word)), || {
        format!("the content of `{port}` is not in small letters with hyphens, as `mean-luminance` is")
    });
}

fn output(kind: &NodeKind, port: &Output, complaints: &mut Violations) {
    let name = &*port.name;
    port_name(name, complaints);
    complaints.require(!port.doc.trim().is_empty(), || format!("the output `{name}` has no doc"));
    complaints
        .require(port.ty != PortType::Block, || format!("the output `{name}` is a Block: hosts alone give these"));
    content(name, port.ty, port.content.as_deref(), complaints);
    complaints.require(port.ty != PortType::Table || port.content.is_some(), || {
        format!("the output `{name}` is a table, which its readers must know: name its layout by `content`")
    });
    match &port.state {
        OutputState::Nothing => {
            complaints
                .require(!is_image(port.ty), || format!("the output `{name}` is an image and must say its state"));
        }
        OutputState::Always(_) => {
            complaints.require(!is_number(port.ty), || {
                format!("the output `{name}` is a {} and has no image state", port.ty.name())
            });
        }
        OutputState::Chosen(param) => {
            let is_choice = kind.param(param).is_some_and(|(_, param)| matches!(param.ty, Type::Choice(_)));
            let follows = kind.inputs().first().is_some_and(|input| !is_number(input.ty) && !input.optional);
            complaints.require(is_choice && follows, || {
                format!("the state of `{name}` needs the choice parameter `{param}` and a required image input first")
            });
        }
        OutputState::Same(source) => {
            let fits = kind.input(source).is_some_and(|input| !is_number(input.ty) && !input.optional);
            complaints.require(fits, || {
                format!("the state of `{name}` follows `{source}`, which is not a required image input")
            });
        }
    }
}

fn fallback(kind: &NodeKind, port: &Output, complaints: &mut Violations) {
    let (name, ty) = (&port.name, port.ty.name());
    match &port.fallback {
        Fallback::Absent => {}
        Fallback::Zero => complaints.require(is_image(port.ty) && port.ty != PortType::Multisampled, || {
            format!("the fallback of `{name}` is zero, but a {ty} has no zero: it may be absent")
        }),
        Fallback::Input(source) => match kind.input(source) {
            None => complaints.add(format!("the fallback of `{name}` is `{source}`, which is not an input")),
            Some(input) => complaints.require(input.ty == port.ty, || {
                format!("the fallback of `{name}` ({ty}) is `{source}` ({})", input.ty.name())
            }),
        },
    }
}

fn parameter(param: &Param, complaints: &mut Violations) {
    let name = &*param.name;
    complaints.require(!param.doc.trim().is_empty(), || format!("the parameter `{name}` has no doc"));
    if let Some((low, high)) = param.domain {
        complaints.require(low.is_finite() && high.is_finite() && low < high, || {
            format!("the domain of `{name}` is not finite")
        });
    }
    if let (Some((low, high)), Some((from, to))) = (param.usual, param.domain) {
        complaints.require(from <= low && low < high && high <= to, || {
            format!("the usual range of `{name}` leaves its domain")
        });
    }
    if matches!(param.ty, Type::Int | Type::Float | Type::Vector(_)) {
        complaints.require(param.domain.is_some(), || format!("the numbers of `{name}` have no domain"));
    }
    let quality = param.quality.iter().flat_map(|quality| std::iter::once(&quality.exact).chain(&quality.cheaper));
    for (what, value) in
        [("default", &param.default)].into_iter().chain(param.neutral.iter().map(|v| ("neutral value", v)))
    {
        acceptable(param, what, value, complaints);
    }
    quality.for_each(|value| acceptable(param, "quality level", value, complaints));
    if let Type::Choice(choices) = param.ty {
        complaints.require(!choices.is_empty(), || format!("the parameter `{name}` has no choices"));
        for choice in choices {
            complaints.require(is_pascal(choice.name), || {
                format!("the choice `{}` of `{name}` is not in PascalCase", choice.name)
            });
            complaints.require(!choice.doc.trim().is_empty(), || {
                format!("the choice `{}` of `{name}` has no doc", choice.name)
            });
        }
    }
}

fn acceptable(param: &Param, what: &str, value: &Value, complaints: &mut Violations) {
    if let Err(why) = param.accepts(value) {
        complaints.add(format!("the {what} of `{}` is not acceptable: {why}", param.name));
    }
}
