//! Order: nothing waits for itself.

use std::collections::VecDeque;

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};

use super::build::Builder;
use afterimage_base::diagnostic::{Diagnostic, quote};

/// Labels of a cycle; a longer cycle is reported by the names of its nodes.
const MOST_LABELS: usize = 8;

impl Builder<'_> {
    /// Reports every cycle of nodes that read each other in the same frame.
    pub(super) fn order(&mut self) {
        let graph = self.same_frame();
        let mut cycles: Vec<Vec<usize>> =
            tarjan_scc(&graph).into_iter().filter_map(|part| cycle(&graph, &part)).collect();
        cycles.sort();
        for cycle in cycles {
            let diagnostic = self.cycle(&cycle);
            self.report(diagnostic);
        }
    }

    /// The nodes of a cycle, each read by the next and the last by the first.
    fn cycle(&self, cycle: &[usize]) -> Diagnostic {
        let names: Vec<String> =
            cycle.iter().chain(&cycle[..1]).map(|node| quote(&self.full_name(&self.drafts[*node]))).collect();
        let told = match names.len() {
            0..=12 => names.join(" -> "),
            n => format!("{} -> ... ({} more) -> {}", names[..8].join(" -> "), n - 9, names[n - 1]),
        };
        let mut diagnostic = Diagnostic::error("cycle", format!("the nodes run in a cycle: {told}"));
        for (index, reader) in cycle.iter().enumerate().take(MOST_LABELS) {
            let maker = cycle[(index + cycle.len() - 1) % cycle.len()];
            let wires = self.drafts[*reader].wires.iter().flatten();
            let Some(wire) = wires.clone().find(|wire| wire.same_frame_node() == Some(maker)) else { continue };
            let text = format!(
                "{} waits for {}",
                quote(&self.drafts[*reader].name.value),
                quote(&self.drafts[maker].name.value)
            );
            diagnostic = if diagnostic.labels.is_empty() {
                diagnostic.at(&wire.location, text)
            } else {
                diagnostic.also(&wire.location, text)
            };
        }
        let last = &self.drafts[cycle[cycle.len() - 1]].name.value;
        diagnostic.help(format!("read what one of them held in the frame before: `\"{last}@previous\"`"))
    }
}

/// A shortest cycle through the first node of a part of the graph in which all nodes reach each other.
fn cycle(graph: &DiGraph<(), ()>, part: &[NodeIndex]) -> Option<Vec<usize>> {
    let start = *part.iter().min()?;
    let is_inside = |node: NodeIndex| part.len() > 1 && part.contains(&node) || node == start;
    let mut came_from = vec![None; graph.node_count()];
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        let mut next: Vec<NodeIndex> = graph.neighbors(node).filter(|next| is_inside(*next)).collect();
        next.sort_unstable();
        for next in next {
            if next == start {
                return Some(trace(&came_from, start, node));
            }
            if came_from[next.index()].is_none() {
                came_from[next.index()] = Some(node);
                queue.push_back(next);
            }
        }
    }
    None
}

/// The way from `start` to `end`.
fn trace(came_from: &[Option<NodeIndex>], start: NodeIndex, end: NodeIndex) -> Vec<usize> {
    let back = std::iter::successors(Some(end), |node| if *node == start { None } else { came_from[node.index()] });
    let mut way: Vec<usize> = back.map(NodeIndex::index).collect();
    way.reverse();
    way
}
