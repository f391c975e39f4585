//! A kind on its own, as the text of a pipeline: its inputs are made from images, its outputs are turned into images.

use std::fmt::Write as _;

use afterimage_graph::image::ColorState;
use afterimage_graph::node::{Input, NodeKind, Output, PortType, Registry};

/// The name of the node under test.
pub const NODE: &str = "it";
/// The most nodes between an image and a port; a longer chain is a cycle.
const MAX_LENGTH: usize = 6;

/// The sections of the pipeline that is being written.
struct PipelineWriter<'r> {
    registry: &'r Registry,
    inputs: String,
    nodes: String,
    outputs: String,
}

/// The wiring of a kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WireOptions<'f> {
    /// Optional inputs stay without a wire.
    pub(crate) bare: bool,
    /// The most frequent use: without optional values, and only its main output is read.
    pub(crate) typical: bool,
    /// The node's images are also read from the previous frame, so that it is not skipped as an identity.
    pub(crate) forced: bool,
    /// The value of parameters that name a file.
    pub(crate) file: &'f str,
}

/// The text of a pipeline that runs a kind on its own.
///
/// # Errors
/// No kind makes one of its inputs or reads one of its outputs: which, and what makes it reachable.
pub(crate) fn pipeline_text(registry: &Registry, kind: &NodeKind, options: WireOptions<'_>) -> Result<String, String> {
    let WireOptions { bare, typical, forced, file } = options;
    let mut writer = PipelineWriter { registry, inputs: String::new(), nodes: String::new(), outputs: String::new() };
    let mut fields = String::new();
    let is_unwired = |port: &Input| port.optional && (bare || typical && port.ty == PortType::Value);
    for port in kind.inputs().iter().filter(|port| !is_unwired(port)) {
        let wire = writer.feed(port, &port.name, 0).ok_or_else(|| no_maker(port))?;
        let _ = write!(fields, "{}: \"{wire}\", ", port.name);
    }
    for param in kind.params().iter().filter(|param| param.ty == afterimage_graph::value::Type::File) {
        let _ = write!(fields, "{}: \"{file}\", ", param.name);
    }
    let _ = writeln!(writer.nodes, "        \"{NODE}\": {}({}),", kind.name(), fields.trim_end_matches(", "));
    for port in kind.outputs().iter().filter(|port| !typical || is_main(kind, port)) {
        writer.show(port).ok_or_else(|| no_reader(port))?;
        if forced && port.ty == PortType::Image {
            let _ = writeln!(writer.outputs, "        \"{}-before\": \"{NODE}.{}@previous\",", port.name, port.name);
        }
    }
    let PipelineWriter { inputs, nodes, outputs, .. } = writer;
    Ok(format!(
        "Pipeline(\n    inputs: {{\n{inputs}    }},\n    nodes: {{\n{nodes}    }},\n    \
         outputs: {{\n{outputs}    }},\n)\n"
    ))
}

impl PipelineWriter<'_> {
    /// Adds what a port needs; returns the wire.
    fn feed(&mut self, port: &Input, name: &str, depth: usize) -> Option<String> {
        if port.ty == PortType::Image {
            let state = port.states.first().copied().unwrap_or(ColorState::Scene);
            let _ = writeln!(self.inputs, "        \"{name}\": {},", input_type(state));
            return Some(name.to_owned());
        }
        if port.ty == PortType::Multisampled {
            let state = port.states.first().copied().unwrap_or(ColorState::Scene);
            let _ = writeln!(self.inputs, "        \"{name}\": {}(multisampled: true),", input_type(state));
            return Some(name.to_owned());
        }
        if port.ty == PortType::Volume && port.content.is_none() {
            let state = port.states.first().copied().unwrap_or(ColorState::Scene);
            let _ = writeln!(self.inputs, "        \"{name}\": {}(volume: true),", input_type(state));
            return Some(name.to_owned());
        }
        if let Some(block) = port.block {
            let _ = writeln!(self.inputs, "        \"{name}\": {},", block.name);
            return Some(name.to_owned());
        }
        if depth == MAX_LENGTH {
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
    fn show(&mut self, port: &Output) -> Option<()> {
        let wire = format!("{NODE}.{}", port.name);
        self.show_wire(port, &wire, &port.name, 0)
    }

    fn show_wire(&mut self, port: &Output, wire: &str, name: &str, depth: usize) -> Option<()> {
        match port.ty {
            PortType::Image => self.output(name, wire),
            PortType::Value => self.show_by(name, &format!("ShowValue(value: \"{wire}\")")),
            PortType::Volume => self.show_by(name, &format!("ShowVolume(volume: \"{wire}\")")),
            PortType::Pyramid => {
                self.show_by(&format!("{name}-finest"), &format!("ShowLevel(pyramid: \"{wire}\", end: Finest)"));
                self.show_by(&format!("{name}-coarsest"), &format!("ShowLevel(pyramid: \"{wire}\", end: Coarsest)"));
            }
            PortType::Table if depth < MAX_LENGTH => return self.read_table(port, wire, name, depth),
            PortType::Table | PortType::Block | PortType::Multisampled => return None,
        }
        Some(())
    }

    /// The layout of a table is known to the kinds that share its content, so a kind that reads it shows it.
    fn read_table(&mut self, table: &Output, wire: &str, name: &str, depth: usize) -> Option<()> {
        let (reader, port) = reader(self.registry, table)?;
        let node = format!("{name}-reader");
        let _ = writeln!(self.nodes, "        \"{node}\": {}({}: \"{wire}\"),", reader.name(), port.name);
        for port in reader.outputs() {
            self.show_wire(port, &format!("{node}.{}", port.name), &format!("{name}-{}", port.name), depth + 1)?;
        }
        Some(())
    }

    fn show_by(&mut self, name: &str, node: &str) {
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

/// The kind that makes what a port accepts: one with the content that the port declares, if there is one.
fn maker<'r>(registry: &'r Registry, port: &Input) -> Option<(&'r NodeKind, &'r Output)> {
    let is_declared = |output: &Output| output.content.is_some() && output.content == port.content;
    let fits = |output: &Output| output.content.is_none() || port.content.is_none();
    let declared = preferred(registry, port.ty, &|_, output| is_declared(output));
    declared.or_else(|| preferred(registry, port.ty, &|kind, output| is_main(kind, output) && fits(output)))
}

/// A kind with such an output. For values preferably one that follows other kinds, as those that meter do; for
/// everything else preferably one that needs only images.
fn preferred<'r>(
    registry: &'r Registry,
    ty: PortType,
    fits: &dyn Fn(&NodeKind, &Output) -> bool,
) -> Option<(&'r NodeKind, &'r Output)> {
    let from_images = |kind: &NodeKind| kind.inputs().iter().all(|port| port.optional || port.ty == PortType::Image);
    let gives = |kind: &'r NodeKind| kind.outputs().iter().find(|output| output.ty == ty && fits(kind, output));
    let makers = || registry.iter().filter_map(|kind| Some((kind, gives(kind)?)));
    makers().find(|(kind, _)| from_images(kind) != (ty == PortType::Value)).or_else(|| makers().next())
}

fn is_main(kind: &NodeKind, output: &Output) -> bool {
    output.name == kind.main_output()
}

/// A kind that reads tables of this content, and the port for them.
fn reader<'r>(registry: &'r Registry, table: &Output) -> Option<(&'r NodeKind, &'r Input)> {
    let takes = |kind: &'r NodeKind| {
        kind.inputs().iter().find(|port| port.ty == PortType::Table && port.content == table.content)
    };
    registry.iter().find_map(|kind| Some((kind, takes(kind)?)))
}

/// The message about an input that nothing makes, with the remedy.
fn no_maker(port: &Input) -> String {
    let ty = port.ty.name();
    let what = match &port.content {
        Some(content) => format!("an output of the type {ty} and the content `{content}`"),
        None => format!("an output of the type {ty}"),
    };
    format!("nothing makes its input `{}`: register a kind that has {what} and can be made from images", port.name)
}

/// The message about an output that nothing reads, with the remedy.
fn no_reader(port: &Output) -> String {
    let what = match &port.content {
        Some(content) => format!("register a kind whose input of the type Table has the content `{content}`"),
        None => "declare its `content`, and register a kind with an input of that content".into(),
    };
    format!("nothing reads the table of its output `{}`: {what}", port.name)
}
