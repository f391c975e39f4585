//! Hints from the table of kinds: the name that was meant, the node that is missing on a wire.

use std::collections::VecDeque;

use crate::node::{NodeKind, OutputState, PortType, Registry};
use afterimage_base::diagnostic::{list, quote};
use afterimage_base::image::ColorState;

/// The type and the state of what is on a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OnWire {
    pub(super) ty: PortType,
    pub(super) state: Option<ColorState>,
}

/// The kinds of a topic: `Bloom`.
pub fn kinds_about(registry: &Registry, topic: &str) -> Option<String> {
    let kinds = registry.about(topic);
    let help = || format!("kinds for that: {}; `afterimage nodes KIND` explains one", list(kinds.iter().copied(), 6));
    (!kinds.is_empty()).then(help)
}

pub(super) fn known_kinds(registry: &Registry) -> String {
    format!("the kinds are {}", list(registry.names(), 40))
}

/// The kinds that lead from one thing to another in as few nodes as possible, the first one next to the source.
pub(super) fn path(registry: &Registry, from: OnWire, is_goal: impl Fn(OnWire) -> bool) -> Option<Vec<&NodeKind>> {
    let mut kinds: Vec<&NodeKind> = registry.iter().collect();
    // The plainest kind is the likeliest: fewest wires, then the shortest name.
    kinds.sort_by_key(|kind| (required(kind), kind.inputs().len(), kind.name().len(), kind.name()));
    let mut seen = vec![from];
    let mut queue: VecDeque<(OnWire, Vec<&NodeKind>)> = VecDeque::from([(from, Vec::new())]);
    while let Some((on_wire, path)) = queue.pop_front() {
        for kind in &kinds {
            let Some(next) = through(kind, on_wire).filter(|next| !seen.contains(next)) else { continue };
            let path: Vec<&NodeKind> = path.iter().copied().chain([*kind]).collect();
            if is_goal(next) {
                return Some(path);
            }
            seen.push(next);
            queue.push_back((next, path));
        }
    }
    None
}

fn required(kind: &NodeKind) -> usize {
    kind.inputs().iter().filter(|port| !port.optional).count()
}

/// Color state of a kind's main output for this state at its first input.
fn through(kind: &NodeKind, on_wire: OnWire) -> Option<OnWire> {
    let port = kind.inputs().first()?;
    let output = kind.outputs().first()?;
    let takes = port.ty == on_wire.ty
        && on_wire.state.is_none_or(|state| port.states.is_empty() || port.states.contains(&state));
    let state = match &output.state {
        OutputState::Always(state) => Some(*state),
        OutputState::Same(name) if *name == port.name => on_wire.state,
        // A new node has the parameter's default, which names no state.
        OutputState::Chosen(_) => on_wire.state,
        // That of a wire which the hint does not name.
        OutputState::Same(_) => return None,
        OutputState::Nothing => None,
    };
    takes.then_some(OnWire { ty: output.ty, state })
}

pub(super) fn between(path: &[&NodeKind]) -> String {
    let names = list(path.iter().map(|kind| kind.name()), 8);
    match path {
        [_] => format!("put a node {names} between them"),
        _ => format!("put the nodes {names} between them, in this order"),
    }
}

/// Alternatives in words: `Scene` or `Exposed`.
pub(super) fn either(states: &[ColorState]) -> String {
    let names: Vec<String> = states.iter().map(|state| quote(state.name())).collect();
    names.join(" or ")
}
