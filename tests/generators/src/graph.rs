//! Random graphs.

use std::collections::BTreeMap;

use afterimage_graph::check::{Graph, GraphInput, GraphNode, GraphOutput, Source};
use afterimage_graph::node::{NodeInstance, NodeKind};
use afterimage_graph::prelude::*;
use petgraph::graph::{DiGraph, NodeIndex};

use crate::kinds::{KINDS, Lay};
use crate::rng::Rng;

/// A random graph. It has one input `picture` and the outputs `shown0` and `shown1`.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// The seed of all choices.
    pub seed: u64,
    /// The least number of nodes; those that join unread images come on top.
    pub nodes: usize,
    /// The number of wires to earlier frames.
    pub histories: usize,
    /// The percentage of nodes that are switched off.
    pub off: u64,
}

/// A graph in the making.
struct Growing {
    rng: Rng,
    nodes: Vec<GraphNode>,
    /// The outputs that can be wired, by type, and those that no node reads yet.
    made: BTreeMap<PortType, Vec<Source>>,
    unread: BTreeMap<PortType, Vec<Source>>,
}

impl Recipe {
    /// The graph; equal recipes give equal graphs.
    pub fn graph(self) -> Graph {
        let made = BTreeMap::from([(PortType::Image, vec![Source::Input(0)])]);
        let mut growing = Growing { rng: Rng::new(self.seed), nodes: Vec::new(), made, unread: BTreeMap::new() };
        while growing.nodes.len() < self.nodes.max(1) {
            growing.add_any(self.off);
        }
        growing.funnel();
        growing.add_histories(self.histories);
        growing.finish()
    }
}

/// Lets some nodes of a graph run in one of several frames only.
pub fn hold_some(graph: &mut Graph, seed: u64) {
    let mut rng = Rng::new(seed);
    for node in &mut graph.nodes {
        if rng.per_cent(30) {
            node.every = [2, 3, 4][rng.below(3)];
        }
    }
}

impl Growing {
    fn add_any(&mut self, off: u64) {
        let kinds = KINDS;
        let mut ticket = self.rng.below(kinds.iter().map(|(_, weight)| *weight as usize).sum());
        let kind = kinds.iter().find(|(_, weight)| {
            let found = ticket < *weight as usize;
            ticket = ticket.saturating_sub(*weight as usize);
            found
        });
        let kind = &kind.expect("the ticket is below the sum of the weights").0;
        let has_all = kind.inputs().iter().all(|input| self.made.contains_key(&input.ty));
        if has_all {
            let wires = kind.inputs().iter().map(|input| self.pick(input.ty)).collect();
            // Whoever needs a volume or a value is starved without it, and so on to the outputs.
            let off = self.rng.per_cent(off) && kind.can_be_off();
            self.add(kind, wires, off);
        }
    }

    /// Mostly something new that nobody reads yet, sometimes anything.
    fn pick(&mut self, ty: PortType) -> Source {
        let unread = self.unread.entry(ty).or_default();
        if !unread.is_empty() && self.rng.per_cent(60) {
            let oldest = unread.len().saturating_sub(8);
            let at = oldest + self.rng.below(unread.len() - oldest);
            return unread.remove(at);
        }
        let made = &self.made[&ty];
        let oldest = if self.rng.per_cent(80) { made.len().saturating_sub(6) } else { 0 };
        made[oldest + self.rng.below(made.len() - oldest)]
    }

    fn add(&mut self, kind: &NodeKind, wires: Vec<Source>, off: bool) {
        for source in &wires {
            self.unread.values_mut().for_each(|unread| unread.retain(|other| other != source));
        }
        let node = self.nodes.len();
        for (output, port) in kind.outputs().iter().enumerate() {
            let source = Source::Node { node, output, previous: 0 };
            self.made.entry(port.ty).or_default().push(source);
            self.unread.entry(port.ty).or_default().push(source);
        }
        let formats = [Format::R16Float, Format::Rg11b10Ufloat, Format::Rgba8Unorm, Format::Rgba32Float];
        let takes_formats = kind.outputs()[0].ty == PortType::Image;
        let format = (takes_formats && self.rng.per_cent(20)).then(|| formats[self.rng.below(formats.len())]);
        self.nodes.push(GraphNode {
            name: format!("{}{node}", kind.name().to_lowercase()),
            instance: NodeInstance::new(kind.clone(), Vec::new()),
            wires: wires.into_iter().map(Some).collect(),
            when: None,
            off,
            format,
            bake: None,
            every: 1,
            label: None,
            states: vec![None; kind.outputs().len()],
        });
    }

    /// Lays all images that nobody reads over each other, so that the last node needs nearly all others.
    fn funnel(&mut self) {
        let lay = NodeKind::of::<Lay>();
        while let [base, over, ..] = self.unread.get(&PortType::Image).map_or(&[][..], Vec::as_slice) {
            let wires = vec![*base, *over];
            self.add(&lay, wires, false);
        }
    }

    /// Turns the second input of some nodes into what an image was in an earlier frame.
    fn add_histories(&mut self, count: usize) {
        let images: Vec<Source> = self.made[&PortType::Image].clone();
        let lays: Vec<usize> = (0..self.nodes.len()).filter(|at| self.nodes[*at].kind().name() == "Lay").collect();
        for _ in 0..count.min(lays.len()) {
            let (reader, past) = (lays[self.rng.below(lays.len())], images[self.rng.below(images.len())]);
            let frames = 1 + self.rng.below(3) as u32;
            if let Source::Node { node, output, .. } = past {
                self.nodes[reader].wires[1] = Some(Source::Node { node, output, previous: frames });
            }
        }
    }

    fn finish(self) -> Graph {
        let mut wires = DiGraph::new();
        self.nodes.iter().for_each(|_| {
            wires.add_node(());
        });
        for (reader, node) in self.nodes.iter().enumerate() {
            for source in node.wires.iter().flatten() {
                if let Source::Node { node, previous: 0, .. } = source {
                    wires.add_edge(NodeIndex::new(*node), NodeIndex::new(reader), ());
                }
            }
        }
        let input = GraphInput {
            name: "picture".into(),
            block: None,
            state: ColorState::Scene,
            min_channels: 1,
            optional: false,
            multisampled: false,
            volume: false,
            needs_alpha: false,
            scale: 1.0,
        };
        let images = &self.made[&PortType::Image];
        let shown = [images[images.len() - 1], images[images.len() / 2]];
        let output = |(index, source): (usize, &Source)| GraphOutput {
            name: format!("shown{index}"),
            source: *source,
            state: ColorState::Scene,
            has_coverage: false,
        };
        let outputs = shown.iter().enumerate().map(output).collect();
        Graph { inputs: vec![input], nodes: self.nodes, outputs, wires }
    }
}
