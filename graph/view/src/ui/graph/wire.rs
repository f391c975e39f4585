//! Ends of wires, as the text of the pipeline names them.

use afterimage_graph::check::{Graph, GraphNode, Reader, Source};

/// The name of a wire for people and for the inspector: an input, or `node.port`.
pub(crate) fn wire_name(graph: &Graph, source: Source) -> String {
    match source {
        Source::Input(input) => graph.inputs[input].name.clone(),
        Source::Node { node, output, .. } => {
            let node = &graph.nodes[node];
            format!("{}.{}", node.name, node.kind().outputs()[output].name)
        }
    }
}

/// A wire as the text writes it. Of a node inside of another pipeline, it is no wire that another node can read.
pub(super) fn wire_text(graph: &Graph, source: Source) -> String {
    let Source::Node { node, output, previous } = source else { return wire_name(graph, source) };
    let path = if output == 0 { graph.nodes[node].name.clone() } else { wire_name(graph, source) };
    earlier(&path, previous)
}

/// A wire so many frames earlier.
pub(super) fn earlier(wire: &str, frames: u32) -> String {
    match frames {
        0 => wire.to_owned(),
        1 => format!("{wire}@previous"),
        frames => format!("{wire}@previous:{frames}"),
    }
}

/// The wired inputs of a node from the top, in the order in which they are drawn.
pub(super) fn wired_inputs(node: &GraphNode) -> impl Iterator<Item = (usize, Source)> + '_ {
    node.wires.iter().enumerate().filter_map(|(port, wire)| Some((port, (*wire)?)))
}

/// An input of a node.
pub(super) fn input_of(node: &GraphNode, port: usize) -> Reader {
    Reader::input(&node.name, &node.kind().inputs()[port].name)
}

/// The source of what an input or output reads.
pub(super) fn source_of(graph: &Graph, reader: &Reader) -> Option<Source> {
    match reader {
        Reader::Input { node, port } => {
            let (_, node) = graph.node(node)?;
            node.wires[node.kind().inputs().iter().position(|input| *input.name == **port)?]
        }
        Reader::Output(name) => Some(graph.outputs.iter().find(|output| output.name == *name)?.source),
    }
}
