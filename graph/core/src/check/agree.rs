//! Agreement of the two ends of every wire: the port's type and the state of the image.

use std::collections::VecDeque;

use super::Source;
use super::draft::{DraftGraph, NodeDraft, Wire, input_type};
use super::reports::Reports;
use super::suggest::{OnWire, between, either, path};
use crate::document::{InputEntry, OutputEntry, image_type_names};
use crate::node::{HostBlock, Input, OutputState, PortType, Registry};
use afterimage_base::diagnostic::{Diagnostic, Location, quote};
use afterimage_base::image::ColorState;
use afterimage_base::value::Value;

/// Compares both ends of the wires of a graph whose color states are known.
pub(super) struct Agreement<'b> {
    pub(super) registry: &'b Registry,
    pub(super) drafted: &'b DraftGraph,
    pub(super) reports: &'b mut Reports,
}

impl Agreement<'_> {
    pub(super) fn agree(&mut self) {
        for draft in &self.drafted.nodes {
            for (port, wire) in draft.kind.inputs().iter().zip(&draft.wires) {
                if let Some(wire) = wire {
                    self.agree_on(wire, port, &format!("{} of {}", quote(&port.name), quote(draft.kind.name())));
                }
            }
        }
        self.agree_with_inner();
        self.agree_with_outputs();
        self.report_unknown_states();
    }

    fn agree_on(&mut self, wire: &Wire, port: &Input, reader: &str) {
        if wire.source.is_none() && wire.declared.is_none() {
            // A block that the host of an inner pipeline leaves out.
            return;
        }
        let on_wire = OnWire { ty: self.drafted.wire_type(wire), state: self.drafted.state(wire).flatten() };
        if on_wire.ty != port.ty {
            let diagnostic = self.type_conflict(wire, on_wire, port.ty, &port.states, reader);
            return self.reports.push(diagnostic);
        }
        match on_wire.state {
            Some(state) if !port.states.is_empty() && !port.states.contains(&state) => {
                let diagnostic = self.state_conflict(wire, on_wire, &port.states, reader);
                self.reports.push(diagnostic.maybe_help(input_for(port)));
            }
            _ => self.agree_on_content(wire, port, reader),
        }
    }

    /// A block is of the type that the port declares.
    fn agree_on_block(&mut self, wire: &Wire, expected: &HostBlock, reader: &str) {
        let Some(Source::Input(input)) = wire.source else { return };
        let Some(found) = self.drafted.host_input(input).and_then(|input| input.block.clone()) else { return };
        if found.value != expected.name {
            let message =
                format!("{reader} accepts a {}, but {} is a {}", expected.name, self.drafted.maker(wire), found.value);
            let (accepts, gives) = (format!("accepts a {}", expected.name), format!("gives a {}", found.value));
            let diagnostic = self.drafted.ends(Diagnostic::error("content-conflict", message), wire, &accepts, &gives);
            self.reports.push(diagnostic.help(format!("declare an input of the type {}", quote(expected.name))));
        }
    }

    /// Tables, values and volumes may declare what their numbers are.
    fn agree_on_content(&mut self, wire: &Wire, port: &Input, reader: &str) {
        if let Some(block) = port.block {
            return self.agree_on_block(wire, block, reader);
        }
        let Some(Source::Node { node, output, .. }) = wire.source else {
            return self.agree_on_host_volume(wire, port, reader);
        };
        let found = self.drafted.nodes[node].kind.outputs()[output].content.clone();
        let (Some(found), Some(expected)) = (found, &port.content) else { return };
        if found == *expected {
            return;
        }
        let between = self.registry.iter().find(|kind| {
            let takes = kind.inputs().iter().any(|input| input.content.as_ref() == Some(&found));
            takes && kind.outputs().iter().any(|output| output.content.as_ref() == Some(expected))
        });
        let help = match between {
            Some(kind) => format!("put a node {} between them", quote(kind.name())),
            None => format!("wire it to a node that gives {}", quote(expected)),
        };
        let message =
            format!("{reader} accepts {}, but {} is {}", quote(expected), self.drafted.maker(wire), quote(&found));
        let (accepts, gives) = (format!("accepts {}", quote(expected)), format!("gives {}", quote(&found)));
        let diagnostic =
            self.drafted.ends(Diagnostic::error("content-conflict", message), wire, &accepts, &gives).help(help);
        self.reports.push(diagnostic);
    }

    /// Nobody knows what the numbers of a host's volume are, so none fits a port that states what it wants.
    fn agree_on_host_volume(&mut self, wire: &Wire, port: &Input, reader: &str) {
        let (PortType::Volume, Some(expected)) = (port.ty, &port.content) else { return };
        let message =
            format!("{reader} accepts {}, but {} is a volume of the host", quote(expected), self.drafted.maker(wire));
        let accepts = format!("accepts {}", quote(expected));
        let diagnostic =
            self.drafted.ends(Diagnostic::error("content-conflict", message), wire, &accepts, "gives a volume");
        self.reports.push(diagnostic.help(format!("wire it to a node that gives {}", quote(expected))));
    }

    fn type_conflict(
        &self,
        wire: &Wire,
        found: OnWire,
        expected: PortType,
        states: &[ColorState],
        reader: &str,
    ) -> Diagnostic {
        let message = format!("{reader} accepts {}, but {} is {}", a(expected), self.drafted.maker(wire), a(found.ty));
        let fits = |state: Option<ColorState>| state.is_none_or(|state| states.is_empty() || states.contains(&state));
        let nodes = path(self.registry, found, |next| next.ty == expected && fits(next.state));
        let help = self.drafted.other_output(wire, expected).or_else(|| nodes.map(|nodes| between(&nodes)));
        let help = help.unwrap_or_else(|| format!("wire it to a node that gives {}", a(expected)));
        self.drafted
            .ends(
                Diagnostic::error("type-conflict", message),
                wire,
                &format!("accepts {}", a(expected)),
                &format!("gives {}", a(found.ty)),
            )
            .help(help)
    }

    fn state_conflict(&self, wire: &Wire, found: OnWire, expected: &[ColorState], reader: &str) -> Diagnostic {
        let state = found.state.map_or("nothing", ColorState::name);
        let message =
            format!("{reader} accepts {}, but {} is {}", either(expected), self.drafted.maker(wire), quote(state));
        let takes = format!("accepts {}", either(expected));
        let nodes =
            path(self.registry, found, |next| next.ty == found.ty && next.state.is_some_and(|s| expected.contains(&s)));
        let otherwise = || match wire.source {
            Some(Source::Input(_)) => {
                format!("wire it to an image that is {}, or correct the type of the input", either(expected))
            }
            _ => format!("wire it to an image from before it became {}", quote(state)),
        };
        let help = nodes.map_or_else(otherwise, |nodes| between(&nodes));
        self.drafted
            .ends(Diagnostic::error("state-conflict", message), wire, &takes, &format!("gives {}", quote(state)))
            .help(help)
    }

    /// The inputs that an inner pipeline declares, against what is wired to it.
    fn agree_with_inner(&mut self) {
        for (scope, input, wire) in &self.drafted.inner_wires {
            let InputEntry { name, state, block, .. } = input;
            let scope = &self.drafted.scopes[*scope].name.value;
            let reader = format!("the input {} of {}", quote(&name.value), quote(scope));
            if let Some(block) = block.as_ref().and_then(|block| self.registry.block(&block.value)) {
                self.agree_on(wire, &Input::block("", block, ""), &reader);
                continue;
            }
            let ty = input_type(input);
            let on_wire = OnWire { ty: self.drafted.wire_type(wire), state: self.drafted.state(wire).flatten() };
            let diagnostic = if on_wire.ty != ty {
                self.type_conflict(wire, on_wire, ty, &[*state], &reader)
            } else if on_wire.state.is_some_and(|found| found != *state) {
                self.state_conflict(wire, on_wire, &[*state], &reader)
            } else {
                continue;
            };
            self.reports.push(diagnostic.also(&name.location, "the inner pipeline declares it here"));
        }
    }

    fn agree_with_outputs(&mut self) {
        for (OutputEntry { name, .. }, wire) in &self.drafted.outputs {
            let Some(wire) = wire else { continue };
            let ty = self.drafted.wire_type(wire);
            if ty != PortType::Image {
                let state = self.drafted.state(wire).flatten();
                let output = format!("the output {}", quote(&name.value));
                let diagnostic = self.type_conflict(wire, OnWire { ty, state }, PortType::Image, &[], &output);
                self.reports.push(diagnostic);
            }
        }
    }

    /// States that follow each other in a cycle of `@previous` wires and begin nowhere.
    fn report_unknown_states(&mut self) {
        if self.reports.diagnostics.has_errors() {
            return;
        }
        let lost = self.drafted.nodes.iter().find(|draft| draft.states.iter().any(Option::is_none));
        if let Some(draft) = lost {
            let message = format!("nothing says what the image of {} is", quote(&draft.name.value));
            let diagnostic = Diagnostic::error("unknown-state", message)
                .at(&draft.kind_location, "this follows its input, which follows it")
                .help("let one node of the cycle read an input, or a node that makes an image");
            self.reports.push(diagnostic);
        }
    }
}

impl DraftGraph {
    /// The state of what a wire carries; `None` while it is unknown.
    pub(super) fn state(&self, wire: &Wire) -> Option<Option<ColorState>> {
        if let Some(declared) = wire.declared {
            return Some(Some(declared));
        }
        match wire.source? {
            Source::Input(input) => self.host_input(input).map(|input| input.block.is_none().then_some(input.state)),
            Source::Node { node, output, .. } => self.nodes[node].states[output],
        }
    }

    fn wire_type(&self, wire: &Wire) -> PortType {
        match (wire.declared, wire.source) {
            (None, Some(source)) => self.port_type(source),
            _ => PortType::Image,
        }
    }

    /// Finds the color states of all outputs, each once the input that it follows is known. `@previous` wires may form
    /// cycles.
    pub(super) fn find_states(&mut self) {
        let mut readers = vec![Vec::new(); self.nodes.len()];
        for (reader, draft) in self.nodes.iter().enumerate() {
            for wire in draft.wires.iter().flatten() {
                if let Some(Source::Node { node, .. }) = wire.source {
                    readers[node].push(reader);
                }
            }
        }
        let mut queue: VecDeque<usize> = (0..self.nodes.len()).collect();
        while let Some(node) = queue.pop_front() {
            let states = self.states_of(node);
            if states != self.nodes[node].states {
                self.nodes[node].states = states;
                queue.extend(&readers[node]);
            }
        }
    }

    fn states_of(&self, node: usize) -> Vec<Option<Option<ColorState>>> {
        let draft = &self.nodes[node];
        let mut states = Vec::new();
        for output in draft.kind.outputs() {
            states.push(match &output.state {
                OutputState::Always(state) => Some(Some(*state)),
                OutputState::Same(name) => self.state_at(draft, name),
                OutputState::Chosen(param) => match (chosen_state(draft, param), draft.kind.inputs().first()) {
                    (Some(state), _) => Some(Some(state)),
                    (None, first) => first.and_then(|first| self.state_at(draft, &first.name)),
                },
                OutputState::Nothing => Some(None),
            });
        }
        states
    }

    /// The state of what arrives at an input. One that the port refuses is reported there, and nothing that follows
    /// from it is.
    fn state_at(&self, draft: &NodeDraft, input: &str) -> Option<Option<ColorState>> {
        let port = draft.kind.inputs().iter().position(|port| port.name == input)?;
        let state = self.state(draft.wires[port].as_ref()?)?;
        let accepted = &draft.kind.inputs()[port].states;
        Some(state.filter(|state| accepted.is_empty() || accepted.contains(state)))
    }

    /// An output of the same node that would fit.
    fn other_output(&self, wire: &Wire, expected: PortType) -> Option<String> {
        let Some(Source::Node { node, .. }) = wire.source else { return None };
        let draft = &self.nodes[node];
        let output = draft.kind.outputs().iter().find(|output| output.ty == expected)?;
        let name = &draft.name.value;
        Some(format!("`\"{name}.{}\"` is {}", output.name, a(expected)))
    }

    /// Description of the source of a wire.
    fn maker(&self, wire: &Wire) -> String {
        match wire.source {
            Some(Source::Node { node, output, .. }) => {
                let draft = &self.nodes[node];
                let name = &draft.name.value;
                match output {
                    0 => quote(name),
                    _ => quote(&format!("{name}.{}", draft.kind.outputs()[output].name)),
                }
            }
            Some(Source::Input(input)) => self
                .host_input(input)
                .map_or_else(String::new, |input| format!("the input {}", quote(&input.name.value))),
            None => "the input".into(),
        }
    }

    fn maker_location(&self, wire: &Wire) -> Option<Location> {
        match wire.source? {
            Source::Node { node, .. } => Some(self.nodes[node].kind_location.clone()),
            Source::Input(input) => self.host_input(input).map(|input| input.name.location.clone()),
        }
    }

    /// Points at both ends of a wire.
    fn ends(&self, diagnostic: Diagnostic, wire: &Wire, reader: &str, maker: &str) -> Diagnostic {
        let diagnostic = diagnostic.at(&wire.location, format!("this {reader}"));
        match self.maker_location(wire).filter(|location| *location != wire.location) {
            Some(location) => diagnostic.also(&location, format!("this {maker}")),
            None => diagnostic,
        }
    }
}

/// The color state that a choice parameter of a node names, if its value is the name of one.
fn chosen_state(draft: &NodeDraft, param: &str) -> Option<ColorState> {
    let (index, _) = draft.kind.param(param)?;
    match draft.values[index] {
        Value::Choice(name) => ColorState::named(name),
        _ => None,
    }
}

/// The type with its article.
fn a(ty: PortType) -> String {
    let article = if ty == PortType::Image { "an" } else { "a" };
    format!("{article} {}", ty.name())
}

/// For a port whose data no node makes: the input to declare for it.
fn input_for(port: &Input) -> Option<String> {
    let is_made = |name: &str| name == "Mask" || name == "Data";
    let name = image_type_names().find(|name| name.eq_ignore_ascii_case(&port.name))?;
    let help = || format!("declare an input for it: `inputs: {{ \"{}\": {name} }}`", port.name);
    (port.states.iter().eq([&ColorState::Data]) && !is_made(name)).then(help)
}
