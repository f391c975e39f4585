//! Order: nothing waits for itself.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

use super::draft::DraftGraph;
use super::reports::Reports;
use afterimage_base::diagnostic::{Diagnostic, quote};

/// Labels of a cycle; a longer cycle is reported by the names of its nodes.
const MAX_LABELS: usize = 8;

impl DraftGraph {
    /// Reports every cycle of nodes that read each other in the same frame.
    pub(super) fn order(&self, reports: &mut Reports) {
        let graph = self.same_frame();
        // Tarjan's algorithm would recurse once for each node of a chain.
        let mut cycles: Vec<Vec<usize>> =
            kosaraju_scc(&graph).into_iter().filter_map(|part| cycle(&graph, &part)).collect();
        cycles.sort();
        for cycle in cycles {
            let diagnostic = self.cycle(&cycle);
            // A wire whose state does not fit is wrong in any frame, and the reason of the cycle.
            let misfits = reports.diagnostics.iter().filter(|other| other.code == "state-conflict");
            let mut misfits = misfits.filter_map(|other| other.labels.first()).map(|label| &label.location);
            if !misfits.any(|place| diagnostic.labels.iter().any(|label| label.location == *place)) {
                reports.push(diagnostic);
            }
        }
    }

    /// The nodes of a cycle, each read by the next and the last by the first.
    fn cycle(&self, cycle: &[usize]) -> Diagnostic {
        let names: Vec<String> =
            cycle.iter().chain(&cycle[..1]).map(|node| quote(&self.full_name(&self.nodes[*node]))).collect();
        let told = match names.len() {
            0..=12 => names.join(" -> "),
            n => format!("{} -> ... ({} more) -> {}", names[..8].join(" -> "), n - 9, names[n - 1]),
        };
        let mut diagnostic = Diagnostic::error("cycle", format!("the nodes run in a cycle: {told}"));
        for (index, reader) in cycle.iter().enumerate().take(MAX_LABELS) {
            let maker = cycle[(index + cycle.len() - 1) % cycle.len()];
            let wires = self.nodes[*reader].wires.iter().flatten();
            let Some(wire) = wires.clone().find(|wire| wire.same_frame_node() == Some(maker)) else { continue };
            let text = format!(
                "{} waits for {}",
                quote(&self.nodes[*reader].name.value),
                quote(&self.nodes[maker].name.value)
            );
            diagnostic = if diagnostic.labels.is_empty() {
                diagnostic.at(&wire.location, text)
            } else {
                diagnostic.also(&wire.location, text)
            };
        }
        let last = &self.nodes[cycle[cycle.len() - 1]].name.value;
        diagnostic.help(format!("read what one of them held in the frame before: `\"{last}@previous\"`"))
    }
}

/// A shortest cycle through the first node of a part of the graph in which all nodes reach each other.
fn cycle(graph: &DiGraph<(), ()>, part: &[NodeIndex]) -> Option<Vec<usize>> {
    let start = *part.iter().min()?;
    let inside: BTreeSet<NodeIndex> = part.iter().copied().collect();
    let mut came_from = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        let mut next: Vec<NodeIndex> = graph.neighbors(node).filter(|next| inside.contains(next)).collect();
        next.sort_unstable();
        for next in next {
            if next == start {
                return Some(trace(&came_from, start, node));
            }
            came_from.entry(next).or_insert_with(|| {
                queue.push_back(next);
                node
            });
        }
    }
    None
}

/// The way from `start` to `end`.
fn trace(came_from: &BTreeMap<NodeIndex, NodeIndex>, start: NodeIndex, end: NodeIndex) -> Vec<usize> {
    let before = |node: &NodeIndex| if *node == start { None } else { came_from.get(node).copied() };
    let back = std::iter::successors(Some(end), before);
    let mut way: Vec<usize> = back.map(NodeIndex::index).collect();
    way.reverse();
    way
}
