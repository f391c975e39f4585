//! A kind on its own, as the text of a pipeline: its inputs are made from images, its outputs are turned into images.

use std::fmt::Write as _;

use afterimage_graph::image::ColorState;
use afterimage_graph::node::{Input, NodeKind, Output, PortType, Registry};

/// The name of the node under test.
pub(crate) const NODE: &str = "it";
/// The most nodes between an image and a port; a longer chain is a cycle.
const LONGEST: usize = 6;

/// The text under construction.
struct Wiring<'r> {
    registry: &'r Registry,
    inputs: String,
    nodes: String,
    outputs: String,
}

/// How a kind is wired.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wires<'f> {
    /// Whether optional inputs stay without a wire.
    pub(crate) bare: bool,
    /// Whether the node's images are also read from the previous frame, so that it is not skipped as an identity.
    pub(crate) forced: bool,
    /// The value of parameters that name a file.
    pub(crate) file: &'f str,
}

/// The pipeline that runs a kind on its own; `None` if no kind makes its inputs or reads its outputs.
pub(crate) fn alone(registry: &Registry, kind: &NodeKind, wires: Wires<'_>) -> Option<String> {
    let Wires { bare, forced, file } = wires;
    let mut wiring = Wiring { registry, inputs: String::new(), nodes: String::new(), outputs: String::new() };
    let mut fields = String::new();
    for port in kind.inputs().iter().filter(|port| !(bare && port.optional)) {
        let wire = wiring.feed(port, &port.name, 0)?;
        let _ = write!(fields, "{}: \"{wire}\", ", port.name);
    }
    for param in kind.params().iter().filter(|param| param.ty == afterimage_graph::value::Type::File) {
        let _ = write!(fields, "{}: \"{file}\", ", param.name);
    }
    let _ = writeln!(wiring.nodes, "        \"{NODE}\": {}({}),", kind.name(), fields.trim_end_matches(", "));
    for port in kind.outputs() {
        wiring.show(port, kind, 0)?;
        if forced && port.ty == PortType::Image {
            let _ = writeln!(wiring.outputs, "        \"{}-before\": \"{NODE}.{}@previous\",", port.name, port.name);
        }
    }
    let Wiring { inputs, nodes, outputs, .. } = wiring;
    Some(format!(
        "Pipeline(\n    inputs: {{\n{inputs}    }},\n    nodes: {{\n{nodes}    }},\n    \
         outputs: {{\n{outputs}    }},\n)\n"
    ))
}

impl Wiring<'_> {
    /// Adds what a port needs; returns the wire.
    fn feed(&mut self, port: &Input, name: &str, depth: usize) -> Option<String> {
        if port.ty == PortType::Image {
            let state = port.states.first().copied().unwrap_or(ColorState::Scene);
            let _ = writeln!(self.inputs, "        \"{name}\": {},", input_type(state));
            return Some(name.to_owned());
        }
        if depth == LONGEST {
            return None;
        }
        let (kind, output) = maker(self.registry, port)?;
        let mut fields = Vec::new();
        for port in kind.inputs().iter().filter(|port| !port.optional) {
            let wire = self.feed(port, &format!("{name}-{}", port.name), depth + 1)?;
            fields.push(format!("{}: \"{wire}\"", port.name));
        }
        let node = format!("{name}-maker");
        let _ = writeln!(self.nodes, "        \"{node}\": {}({}),", kind.name(), fields.join(", "));
        Some(format!("{node}.{}", output.name))
    }

    /// Adds outputs that show a port of the kind.
    fn show(&mut self, port: &Output, kind: &NodeKind, depth: usize) -> Option<()> {
        let wire = format!("{NODE}.{}", port.name);
        self.show_wire(port, kind, &wire, &port.name, depth)
    }

    fn show_wire(&mut self, port: &Output, kind: &NodeKind, wire: &str, name: &str, depth: usize) -> Option<()> {
        match port.ty {
            PortType::Image => self.output(name, wire),
            PortType::Value => self.probe(name, &format!("ProbeValue(value: \"{wire}\")")),
            PortType::Volume => self.probe(name, &format!("ProbeVolume(volume: \"{wire}\")")),
            PortType::Pyramid => {
                self.probe(&format!("{name}-finest"), &format!("ProbeLevel(pyramid: \"{wire}\", end: Finest)"));
                self.probe(&format!("{name}-coarsest"), &format!("ProbeLevel(pyramid: \"{wire}\", end: Coarsest)"));
            }
            PortType::Table if depth < LONGEST => return self.read_table(kind, wire, name, depth),
            PortType::Table => return None,
        }
        Some(())
    }

    /// The layout of a table is known to the two kinds that share it, so a kind that reads it shows its content.
    fn read_table(&mut self, kind: &NodeKind, wire: &str, name: &str, depth: usize) -> Option<()> {
        let (reader, port) = reader(self.registry, kind)?;
        let node = format!("{name}-reader");
        let _ = writeln!(self.nodes, "        \"{node}\": {}({}: \"{wire}\"),", reader.name(), port.name);
        for port in reader.outputs() {
            self.show_wire(
                port,
                reader,
                &format!("{node}.{}", port.name),
                &format!("{name}-{}", port.name),
                depth + 1,
            )?;
        }
        Some(())
    }

    fn probe(&mut self, name: &str, node: &str) {
        let _ = writeln!(self.nodes, "        \"{name}-seen\": {node},");
        self.output(name, &format!("{name}-seen"));
    }

    fn output(&mut self, name: &str, wire: &str) {
        let _ = writeln!(self.outputs, "        \"{name}\": \"{wire}\",");
    }
}

/// The type of an input in pipeline files.
fn input_type(state: ColorState) -> &'static str {
    match state {
        ColorState::Scene => "Color",
        other => other.name(),
    }
}

/// The kind that makes what a port accepts: the one that its documentation names, or the first.
fn maker<'r>(registry: &'r Registry, port: &Input) -> Option<(&'r NodeKind, &'r Output)> {
    let gives = |kind: &'r NodeKind| kind.outputs().iter().find(|output| output.ty == port.ty);
    let is_named = |kind: &&NodeKind| port.doc.contains(kind.name());
    let named = registry.iter().filter(is_named).find_map(|kind| Some((kind, gives(kind)?)));
    named.or_else(|| {
        let from_images =
            |kind: &NodeKind| kind.inputs().iter().all(|input| input.optional || input.ty == PortType::Image);
        // Values come from metering kinds that follow other kinds; everything else is preferably made from images
        // directly.
        let is_preferred = |kind: &&NodeKind| from_images(kind) != (port.ty == PortType::Value);
        let makers = || registry.iter().filter(|kind| gives(kind).is_some_and(|output| is_main(kind, output)));
        let kind = makers().find(is_preferred).or_else(|| makers().next())?;
        Some((kind, gives(kind)?))
    })
}

fn is_main(kind: &NodeKind, output: &Output) -> bool {
    output.name == kind.main_output()
}

/// A kind that reads the tables of another kind, and the port for them.
fn reader<'r>(registry: &'r Registry, maker: &NodeKind) -> Option<(&'r NodeKind, &'r Input)> {
    let takes = |kind: &'r NodeKind| {
        kind.inputs().iter().find(|port| port.ty == PortType::Table && port.doc.contains(maker.name()))
    };
    registry.iter().find_map(|kind| Some((kind, takes(kind)?)))
}
