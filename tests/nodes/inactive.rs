//! Parameters that a kind declares to be without effect.

use std::sync::Arc;

use afterimage_graph::node::{NodeKind, Registry};
use afterimage_graph::value::{Param, Type, Value, When};
use afterimage_lab::stress::{Overrides, Target, registry};

use crate::support::gpu::{Picture, Run};

/// A node of a kind in the state in which a condition does not hold: whether its optional inputs stay unwired, and the
/// value of another parameter.
#[derive(Clone, Debug, PartialEq)]
struct State {
    bare: bool,
    set: Overrides,
}

/// A state in which a condition does not hold.
fn unmet(kind: &NodeKind, condition: &When) -> State {
    let set = |name: &str, value: &Value| vec![(format!("it.{name}"), value.to_string())];
    let state = |set| State { bare: false, set };
    match condition {
        When::OneOf(name, values) => {
            let (_, param) = kind.param(name).unwrap();
            state(set(name, all(param).iter().find(|value| !values.contains(value)).unwrap()))
        }
        When::NoneOf(name, values) => state(set(name, &values[0])),
        When::Wired(_, is_wired) => State { bare: *is_wired, set: Vec::new() },
    }
}

/// All choices of a parameter, or the ends and the middle of its domain.
fn all(param: &Param) -> Vec<Value> {
    match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        _ => [param.highest(), param.lowest(), param.middle()].into_iter().flatten().collect(),
    }
}

/// What the kind makes in a state, with further overrides; `None` if it refuses them.
fn made(registry: &Arc<Registry>, kind: &NodeKind, state: &State, more: &[(String, String)]) -> Option<Vec<Picture>> {
    let target = Target::kind(registry, kind, state.bare).unwrap();
    let graph = target.graph(&[&state.set, more].concat()).ok()?;
    let images = graph.inputs.iter().filter(|input| input.block.is_none());
    let picture = Picture::new(24, 40, |x, y| {
        let light = ((x * 7 + y * 3) % 13) as f32 / 3.0;
        [light, 0.6 * light, 0.1 + 0.2 * light, 0.8]
    });
    let pictures: Vec<(&str, &Picture)> = images.map(|input| (&*input.name, &picture)).collect();
    let mut run = Run::new(&graph);
    for input in graph.inputs.iter().filter(|input| input.block.is_some()) {
        run = run.block(&input.name, &super::surface::eye());
    }
    Some(run.frame(&pictures))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_whose_condition_does_not_hold_changes_no_pixel() {
    let registry = registry(&[afterimage_nodes::ALL]).unwrap();
    for kind in afterimage_nodes::ALL {
        let conditions = kind.params().iter().flat_map(|param| &param.when);
        let mut states: Vec<State> = conditions.map(|condition| unmet(kind, condition)).collect();
        states.dedup();
        for state in states {
            let is_idle = |param: &&Param| param.when.iter().any(|condition| unmet(kind, condition) == state);
            let idle: Vec<&Param> = kind.params().iter().filter(is_idle).collect();
            let before = made(&registry, kind, &state, &[]).unwrap();
            let other = |param: &Param| all(param).into_iter().find(|value| *value != param.default).unwrap();
            let change = |param: &&Param| (format!("it.{}", param.name), other(param).to_string());
            let changes: Overrides = idle.iter().map(change).collect();
            let Some(after) = made(&registry, kind, &state, &changes) else { continue };
            let is_equal = before.iter().zip(&after).all(|(a, b)| a.pixels == b.pixels);
            assert!(is_equal, "{} in the state {state:?} with {changes:?}", kind.name());
        }
    }
}
