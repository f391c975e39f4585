//! Checks of a kind's declaration: names, manual, ports, parameters.

use std::collections::BTreeSet;

use super::names::{RESERVED, is_free_in_wgsl, is_pascal, is_snake};
use super::violations::Violations;
use crate::node::{Fallback, Input, NodeKind, Output, OutputState, PortType};
use afterimage_base::value::{Param, Type, Value, When};

/// Names that pipeline files and shaders use for other things.
const TAKEN: [&str; 8] = ["when", "format", "bake", "every", "label", "at", "frame", "params"];

pub(super) fn look(kind: &NodeKind, violations: &mut Violations) {
    violations.require(is_pascal(kind.name()), || "the name is not in PascalCase".into());
    violations.require(!RESERVED.contains(&kind.name()), || "pipeline files use this name themselves".into());
    violations.require(!kind.doc().trim().is_empty(), || "there is no doc".into());
    names(kind, violations);
    kind.inputs().iter().for_each(|port| input(port, violations));
    violations.require(!kind.outputs().is_empty(), || "there is no output".into());
    kind.outputs().iter().for_each(|port| output(kind, port, violations));
    kind.outputs().iter().for_each(|port| fallback(kind, port, violations));
    kind.params().iter().for_each(|param| parameter(param, violations));
    kind.params().iter().for_each(|param| conditions(kind, param, violations));
}

/// Conditions name other parameters, with values of these, and optional inputs.
fn conditions(kind: &NodeKind, param: &Param, violations: &mut Violations) {
    for condition in &param.when {
        match condition {
            When::OneOf(name, values) | When::NoneOf(name, values) => match kind.param(name) {
                Some((_, other)) if other.name != param.name => {
                    violations.require(!values.is_empty(), || format!("a condition of `{}` has no value", param.name));
                    let what = format!("condition of `{}`", param.name);
                    values.iter().for_each(|value| acceptable(other, &what, value, violations));
                }
                _ => violations.add(format!("the condition `{name}` of `{}` is no other parameter", param.name)),
            },
            When::Wired(input, _) => {
                violations.require(kind.input(input).is_some_and(|port| port.optional), || {
                    format!("the condition `{input}` of `{}` is no optional input", param.name)
                });
            }
        }
    }
}

fn names(kind: &NodeKind, violations: &mut Violations) {
    let inputs = kind.inputs().iter().map(|port| &*port.name);
    let params = kind.params().iter().map(|param| &*param.name);
    distinct(inputs.chain(params), violations);
    distinct(kind.outputs().iter().map(|port| &*port.name), violations);
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>, violations: &mut Violations) {
    let mut seen = BTreeSet::new();
    for name in names {
        violations.require(seen.insert(name), || format!("the name `{name}` is given twice"));
        violations.require(is_snake(name), || format!("the name `{name}` is not in snake_case"));
        violations.require(!TAKEN.contains(&name), || {
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
fn port_name(name: &str, violations: &mut Violations) {
    violations
        .require(is_free_in_wgsl(name), || format!("`{name}` is a word of WGSL and cannot be the name of a port"));
}

fn input(port: &Input, violations: &mut Violations) {
    let name = &*port.name;
    port_name(name, violations);
    violations.require(!port.doc.trim().is_empty(), || format!("the input `{name}` has no doc"));
    violations.require(!is_number(port.ty) || port.states.is_empty(), || {
        format!("the input `{name}` is a {} and has no image state", port.ty.name())
    });
    violations.require((port.ty == PortType::Block) == port.block.is_some(), || {
        format!("the input `{name}` is a block without a declaration, or has one and is none: use `Input::block`")
    });
    content(name, port.ty, port.content.as_deref(), violations);
}

/// Images and pyramids have a color state, which states what their numbers are.
fn content(port: &str, ty: PortType, content: Option<&str>, violations: &mut Violations) {
    violations.require(content.is_none() || !is_image(ty), || {
        format!("`{port}` is a {} and has no content but its color state", ty.name())
    });
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    violations.require(content.is_none_or(|name| !name.is_empty() && name.chars().all(is_word)), || {
        format!("the content of `{port}` is not in small letters with hyphens, as `mean-luminance` is")
    });
}

fn output(kind: &NodeKind, port: &Output, violations: &mut Violations) {
    let name = &*port.name;
    port_name(name, violations);
    violations.require(!port.doc.trim().is_empty(), || format!("the output `{name}` has no doc"));
    violations
        .require(port.ty != PortType::Block, || format!("the output `{name}` is a Block: hosts alone give these"));
    content(name, port.ty, port.content.as_deref(), violations);
    violations.require(port.ty != PortType::Table || port.content.is_some(), || {
        format!("the output `{name}` is a table, which its readers must know: name its layout by `content`")
    });
    match &port.state {
        OutputState::Nothing => {
            violations
                .require(!is_image(port.ty), || format!("the output `{name}` is an image and must say its state"));
        }
        OutputState::Always(_) => {
            violations.require(!is_number(port.ty), || {
                format!("the output `{name}` is a {} and has no image state", port.ty.name())
            });
        }
        OutputState::Chosen(param) => {
            let is_choice = kind.param(param).is_some_and(|(_, param)| matches!(param.ty, Type::Choice(_)));
            let follows = kind.inputs().first().is_some_and(|input| !is_number(input.ty) && !input.optional);
            violations.require(is_choice && follows, || {
                format!("the state of `{name}` needs the choice parameter `{param}` and a required image input first")
            });
        }
        OutputState::Same(source) => {
            let fits = kind.input(source).is_some_and(|input| !is_number(input.ty) && !input.optional);
            violations.require(fits, || {
                format!("the state of `{name}` follows `{source}`, which is not a required image input")
            });
        }
    }
}

fn fallback(kind: &NodeKind, port: &Output, violations: &mut Violations) {
    let (name, ty) = (&port.name, port.ty.name());
    match &port.fallback {
        Fallback::Absent => {}
        Fallback::Zero => violations.require(is_image(port.ty) && port.ty != PortType::Multisampled, || {
            format!("the fallback of `{name}` is zero, but a {ty} has no zero: it may be absent")
        }),
        Fallback::Input(source) => match kind.input(source) {
            None => violations.add(format!("the fallback of `{name}` is `{source}`, which is not an input")),
            Some(input) => violations.require(input.ty == port.ty, || {
                format!("the fallback of `{name}` ({ty}) is `{source}` ({})", input.ty.name())
            }),
        },
    }
}

fn parameter(param: &Param, violations: &mut Violations) {
    let name = &*param.name;
    violations.require(!param.doc.trim().is_empty(), || format!("the parameter `{name}` has no doc"));
    if let Some((low, high)) = param.domain {
        violations.require(low.is_finite() && high.is_finite() && low < high, || {
            format!("the domain of `{name}` is not finite")
        });
    }
    if let (Some((low, high)), Some((from, to))) = (param.usual, param.domain) {
        violations.require(from <= low && low < high && high <= to, || {
            format!("the usual range of `{name}` leaves its domain")
        });
    }
    if param.logarithmic {
        let range = param.usual.or(param.domain).filter(|_| matches!(param.ty, Type::Int | Type::Float));
        violations.require(range.is_some_and(|(low, _)| low >= 0.0), || {
            format!("`{name}` is logarithmic, but is no number with a range from zero or above")
        });
    }
    if matches!(param.ty, Type::Int | Type::Float | Type::Vector(_)) {
        violations.require(param.domain.is_some(), || format!("the numbers of `{name}` have no domain"));
    }
    let quality = param.quality.iter().flat_map(|quality| std::iter::once(&quality.exact).chain(&quality.cheaper));
    for (what, value) in
        [("default", &param.default)].into_iter().chain(param.neutral.iter().map(|v| ("neutral value", v)))
    {
        acceptable(param, what, value, violations);
    }
    quality.for_each(|value| acceptable(param, "quality level", value, violations));
    if let Type::Choice(choices) = param.ty {
        violations.require(!choices.is_empty(), || format!("the parameter `{name}` has no choices"));
        for choice in choices {
            violations.require(is_pascal(choice.name), || {
                format!("the choice `{}` of `{name}` is not in PascalCase", choice.name)
            });
            violations.require(!choice.doc.trim().is_empty(), || {
                format!("the choice `{}` of `{name}` has no doc", choice.name)
            });
        }
    }
}

fn acceptable(param: &Param, what: &str, value: &Value, violations: &mut Violations) {
    if let Err(why) = param.accepts(value) {
        violations.add(format!("the {what} of `{}` is not acceptable: {why}", param.name));
    }
}
