//! Layout of the nodes of a graph in ranks from left to right, so that wires go to the right.

use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::PortType;
use petgraph::Direction;
use petgraph::graph::NodeIndex;

/// A box of the drawing: an input or an output of the pipeline, or a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Item {
    /// An input of the pipeline.
    Input(usize),
    Node(usize),
    /// An output of the pipeline.
    Output(usize),
}

/// A box and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) item: Item,
    pub(super) rank: usize,
    /// Its upper end, in rows.
    pub(super) row: f32,
    /// Its height in rows: one for the name, and one for each port on the side that has more.
    pub(super) rows: f32,
}

/// Rows between two boxes of a column.
const GAP: f32 = 0.8;
/// Number of passes that order the columns by their neighbors.
const SWEEPS: usize = 48;

/// Rows that a thumbnail takes.
pub(super) const THUMBNAIL: f32 = 3.8;

/// Places the inputs, nodes and outputs of a graph, with room for thumbnails or without.
pub(super) fn layout(graph: &Graph, has_thumbnails: bool) -> Vec<Placed> {
    let ranks = ranks(graph);
    let room = |source| if has_thumbnails && has_image(graph.port_type(source)) { THUMBNAIL } else { 0.0 };
    let inputs = (0..graph.inputs.len()).map(|input| (Item::Input(input), 0, 1.6 + room(Source::Input(input))));
    let nodes = graph.nodes.iter().enumerate().map(|(node, found)| {
        let ports = found.wires.iter().filter(|wire| wire.is_some()).count().max(found.kind().outputs().len());
        let room = room(Source::Node { node, output: 0, previous: 0 });
        (Item::Node(node), ranks[node], 1.2 + ports as f32 + room)
    });
    let outputs = graph.outputs.iter().enumerate().map(|(index, output)| {
        let rank = if let Source::Node { node, .. } = output.source { ranks[node] } else { 0 };
        (Item::Output(index), rank + 1, 1.6)
    });
    let place = |(item, rank, rows): (Item, usize, f32)| Placed { item, rank, row: 0.0, rows };
    let mut placed: Vec<Placed> = inputs.chain(nodes).chain(outputs).map(place).collect();
    stack(&mut placed);
    for _ in 0..SWEEPS {
        align(graph, &mut placed);
    }
    placed
}

/// True for wires that carry what can be seen.
pub(super) fn has_image(ty: PortType) -> bool {
    matches!(ty, PortType::Image | PortType::Pyramid | PortType::Volume)
}

/// The rank of each node: one more than the largest of those that it reads.
fn ranks(graph: &Graph) -> Vec<usize> {
    let mut ranks = vec![1; graph.nodes.len()];
    // Nodes may stand in any order in the file, and a rank is at most the number of nodes.
    for _ in 0..graph.nodes.len() {
        let before = ranks.clone();
        for node in 0..graph.nodes.len() {
            let read = graph.wires.neighbors_directed(NodeIndex::new(node), Direction::Incoming);
            ranks[node] = read.map(|other| ranks[other.index()] + 1).max().unwrap_or(1).max(1);
        }
        if ranks == before {
            break;
        }
    }
    ranks
}

/// Puts the boxes of each column below each other, in their present order and as near to their places as they fit.
fn stack(placed: &mut [Placed]) {
    let ranks = placed.iter().map(|placed| placed.rank).max().unwrap_or(0);
    for rank in 0..=ranks {
        let mut column: Vec<&mut Placed> = placed.iter_mut().filter(|placed| placed.rank == rank).collect();
        column.sort_by(|a, b| a.row.total_cmp(&b.row));
        let height: f32 = column.iter().map(|placed| placed.row).sum();
        let mut next = f32::MIN;
        for placed in &mut column {
            placed.row = placed.row.max(next);
            next = placed.row + placed.rows + GAP;
        }
        // Boxes were moved down only. Without this the whole drawing would sink step by step.
        let sunk = (column.iter().map(|placed| placed.row).sum::<f32>() - height) / column.len().max(1) as f32;
        column.iter_mut().for_each(|placed| placed.row -= sunk);
    }
}

/// Moves each box to the mean of those that it is wired to, then takes overlaps away.
fn align(graph: &Graph, placed: &mut [Placed]) {
    let middles: Vec<(Item, f32)> = placed.iter().map(|placed| (placed.item, placed.row + placed.rows / 2.0)).collect();
    let middle = |item: Item| middles.iter().find(|(known, _)| *known == item).map_or(0.0, |(_, middle)| *middle);
    for placed in placed.iter_mut() {
        let neighbors = neighbors(graph, placed.item);
        if !neighbors.is_empty() {
            let mean = neighbors.iter().map(|item| middle(*item)).sum::<f32>() / neighbors.len() as f32;
            placed.row = mean - placed.rows / 2.0;
        }
    }
    stack(placed);
    let least = placed.iter().map(|placed| placed.row).fold(f32::MAX, f32::min);
    placed.iter_mut().for_each(|placed| placed.row -= least);
}

/// The boxes to which a box is wired, on both sides.
fn neighbors(graph: &Graph, item: Item) -> Vec<Item> {
    let reads = |node: usize| graph.nodes[node].wires.iter().flatten().copied().map(Item::of);
    let nodes = (0..graph.nodes.len()).filter(|node| reads(*node).any(|read| read == item)).map(Item::Node);
    let outputs = graph.outputs.iter().enumerate().filter(|(_, output)| Item::of(output.source) == item);
    let read_by = nodes.chain(outputs.map(|(index, _)| Item::Output(index)));
    match item {
        Item::Input(_) => read_by.collect(),
        Item::Node(node) => reads(node).chain(read_by).collect(),
        Item::Output(output) => vec![Item::of(graph.outputs[output].source)],
    }
}

impl Item {
    /// The box that a wire comes from.
    pub(super) fn of(source: Source) -> Self {
        match source {
            Source::Input(input) => Self::Input(input),
            Source::Node { node, .. } => Self::Node(node),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Project, TextProject};

    fn graph(name: &str) -> std::sync::Arc<Graph> {
        let mut project = TextProject::built_in(name).expect("it is built in");
        let text = project.text().to_owned();
        project.check(&text, None).expect("it is valid").graph
    }

    #[test]
    fn every_wire_goes_to_the_right_and_no_boxes_overlap() {
        let names = afterimage_pipelines::PIPELINES.iter().map(|(name, _)| *name);
        for (name, has_thumbnails) in names.flat_map(|name| [(name, false), (name, true)]) {
            let graph = graph(name);
            let placed = layout(&graph, has_thumbnails);
            let rank = |item: Item| placed.iter().find(|placed| placed.item == item).expect("it has a place").rank;
            for (index, node) in graph.nodes.iter().enumerate() {
                for source in node.wires.iter().flatten() {
                    let from = match source {
                        Source::Input(input) => Item::Input(*input),
                        Source::Node { node, previous: 0, .. } => Item::Node(*node),
                        // What an earlier frame has made may stand anywhere.
                        Source::Node { .. } => continue,
                    };
                    assert!(rank(from) < rank(Item::Node(index)), "{name}: {}", node.name);
                }
            }
            for (index, a) in placed.iter().enumerate() {
                let apart = |b: &Placed| a.rank != b.rank || a.row + a.rows < b.row || b.row + b.rows < a.row;
                assert!(placed[index + 1..].iter().all(apart), "{name}: {a:?}");
            }
        }
    }
}
