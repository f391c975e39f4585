//! The meaning of the images on all wires: color states and colorimetry, along the wires that are really in use.
//!
//! The displays that images are encoded for are found first, against the wires. Then the colorimetry of each image
//! follows along the wires. Only nodes that an output needs count.

use std::collections::BTreeSet;

use petgraph::algo::toposort;

use super::displays::{decisive, widest};
use super::{Graph, Source};
use crate::node::{ColorChange, ImageColor, Input, OutputState, PortType};
use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_base::image::ColorState;

/// The meaning of the images of a graph.
#[derive(Clone, Debug)]
pub struct ImageColors {
    inputs: Vec<ImageColor>,
    /// For each node and output; `None` for what is no image, and for nodes that no output needs.
    outputs: Vec<Vec<Option<ImageColor>>>,
    displays: Vec<BTreeSet<Colorimetry>>,
}

impl ImageColors {
    /// The meaning of the image at the beginning of a wire.
    pub fn at(&self, source: Source) -> Option<ImageColor> {
        match source {
            Source::Input(input) => self.inputs.get(input).copied(),
            Source::Node { node, output, .. } => self.of_node(node).get(output).copied().flatten(),
        }
    }

    /// The displays and files that the results of a node are encoded for. Of more than a few only those that decide:
    /// the one with the widest primaries, one for SDR, and for HDR the ones with the least and the greatest luminance
    /// of SDR white and with the least peak.
    pub fn displays_after(&self, node: usize) -> &BTreeSet<Colorimetry> {
        &self.displays[node]
    }

    /// The meaning of the images of each output of a node.
    pub fn of_node(&self, node: usize) -> &[Option<ImageColor>] {
        &self.outputs[node]
    }
}

impl Graph {
    /// The meaning of all images if every node runs.
    pub fn colors(&self) -> ImageColors {
        self.colors_along(&Some)
    }

    /// The meaning of all images along the wires in use: `resolve` states where a wire begins once nodes are replaced
    /// by their fallbacks; `None` for an image that is black, or nothing.
    pub fn colors_along(&self, resolve: &dyn Fn(Source) -> Option<Source>) -> ImageColors {
        let mut flow = Flow::new(self, resolve);
        flow.find_displays();
        flow.find_colors();
        ImageColors { inputs: flow.inputs, outputs: flow.outputs, displays: flow.displays }
    }
}

/// Visits of a node on average after which its color stays as it is.
const MAX_VISITS: usize = 32;

struct Flow<'a> {
    graph: &'a Graph,
    resolve: &'a dyn Fn(Source) -> Option<Source>,
    changes: Vec<ColorChange>,
    /// The nodes that an output needs, each after those that it reads in the same frame.
    order: Vec<usize>,
    /// For each node its place in the order, if it has one.
    places: Vec<Option<usize>>,
    /// For each place the places of the nodes that read the node there.
    readers: Vec<Vec<usize>>,
    /// For each node, what the images after it are encoded for.
    displays: Vec<BTreeSet<Colorimetry>>,
    inputs: Vec<ImageColor>,
    outputs: Vec<Vec<Option<ImageColor>>>,
}

impl<'a> Flow<'a> {
    fn new(graph: &'a Graph, resolve: &'a dyn Fn(Source) -> Option<Source>) -> Self {
        let mut flow = Self {
            graph,
            resolve,
            changes: graph.nodes.iter().map(|node| node.instance.color()).collect(),
            order: Vec::new(),
            places: vec![None; graph.nodes.len()],
            readers: Vec::new(),
            displays: vec![BTreeSet::new(); graph.nodes.len()],
            inputs: graph.inputs.iter().map(|input| ImageColor::of(input.state)).collect(),
            outputs: graph.nodes.iter().map(|node| vec![None; node.kind().outputs().len()]).collect(),
        };
        flow.order = flow.needed();
        flow.order.iter().enumerate().for_each(|(place, node)| flow.places[*node] = Some(place));
        flow.readers = vec![Vec::new(); flow.order.len()];
        for (place, node) in flow.order.iter().enumerate() {
            flow.places_read(*node).into_iter().for_each(|read| flow.readers[read].push(place));
        }
        flow
    }

    /// The places of the nodes that a node reads.
    fn places_read(&self, node: usize) -> Vec<usize> {
        let sources = self.arriving(node).map(|(_, source)| source);
        let place = |source| match source {
            Source::Node { node, .. } => self.places[node],
            Source::Input(_) => None,
        };
        sources.filter_map(place).collect()
    }

    fn needed(&self) -> Vec<usize> {
        let mut needed = vec![false; self.graph.nodes.len()];
        let mut waiting: Vec<Source> = self.graph.outputs.iter().filter_map(|o| (self.resolve)(o.source)).collect();
        while let Some(source) = waiting.pop() {
            if let Source::Node { node, .. } = source
                && !std::mem::replace(&mut needed[node], true)
            {
                waiting.extend(self.arriving(node).map(|(_, source)| source));
            }
        }
        let order = toposort(&self.graph.wires, None).expect("a checked graph has no cycle within a frame");
        order.into_iter().map(|node| node.index()).filter(|node| needed[*node]).collect()
    }

    /// The image inputs of a node to which an image comes, and where it comes from.
    fn arriving(&self, node: usize) -> impl Iterator<Item = (&'a Input, Source)> + '_ {
        let node = &self.graph.nodes[node];
        let wired = node.kind().inputs().iter().zip(&node.wires);
        wired.filter_map(|(port, wire)| Some((port, (self.resolve)((*wire)?)?)))
    }

    /// Against the wires, and again where wires of earlier frames form cycles. What is kept of several displays does
    /// not depend on the order of the visits.
    fn find_displays(&mut self) {
        let mut pending = self.order.clone();
        while let Some(node) = pending.pop() {
            let displays = self.displays_before(node);
            for read in self.places_read(node) {
                let node = self.order[read];
                let all = decisive(self.displays[node].union(&displays).copied().collect());
                if std::mem::replace(&mut self.displays[node], all.clone()) != all {
                    pending.push(node);
                }
            }
        }
    }

    /// The displays that the images which a node reads are for.
    fn displays_before(&self, node: usize) -> BTreeSet<Colorimetry> {
        match self.changes[node] {
            ColorChange::Encode(colorimetry) => BTreeSet::from([colorimetry]),
            ColorChange::ToDisplay | ColorChange::Display(_) => BTreeSet::new(),
            ColorChange::Keep | ColorChange::Adapt(_) => self.displays[node].clone(),
            ColorChange::Refit { white_nits, peak_nits } => {
                let hdr = |after: &Colorimetry| Colorimetry::new(after.primaries, Transfer::Pq);
                let before = |after| hdr(after).nits(white_nits.get(), peak_nits.get());
                self.displays[node].iter().map(before).collect()
            }
        }
    }

    /// Along the wires in rounds, and again where wires of earlier frames form cycles: a round visits the nodes after a
    /// change, in their order.
    fn find_colors(&mut self) {
        let mut round: BTreeSet<usize> = (0..self.order.len()).collect();
        let mut next = BTreeSet::new();
        // Two images that chase each other around a cycle never settle.
        for _ in 0..MAX_VISITS * self.order.len() {
            let Some(place) = round.pop_first() else { break };
            let node = self.order[place];
            let colors = self.colors_of(node);
            if std::mem::replace(&mut self.outputs[node], colors.clone()) != colors {
                let (later, earlier): (Vec<usize>, _) = self.readers[place].iter().partition(|reader| **reader > place);
                round.extend(later);
                next.extend::<Vec<usize>>(earlier);
            }
            if round.is_empty() {
                std::mem::swap(&mut round, &mut next);
            }
        }
    }

    fn at(&self, source: Source) -> Option<ImageColor> {
        match source {
            Source::Input(input) => Some(self.inputs[input]),
            Source::Node { node, output, .. } => self.outputs[node][output],
        }
    }

    fn colors_of(&self, node: usize) -> Vec<Option<ImageColor>> {
        let outputs = self.graph.nodes[node].kind().outputs().iter();
        let states = &self.graph.nodes[node].states;
        outputs.zip(states).map(|(output, state)| self.color_of(node, &output.state, *state)).collect()
    }

    /// The meaning of an output, which is in the color state `found` if it has one.
    fn color_of(&self, node: usize, state: &OutputState, found: Option<ColorState>) -> Option<ImageColor> {
        let mut arriving = self.arriving(node).filter_map(|(port, source)| Some((port, self.at(source)?)));
        let kept = match state {
            OutputState::Nothing => return None,
            OutputState::Same(name) => arriving.find(|(port, _)| port.name == *name)?.1,
            OutputState::Always(_) | OutputState::Chosen(_) => {
                let state = found?;
                let first = arriving.find(|(port, color)| {
                    matches!(port.ty, PortType::Image | PortType::Multisampled) && color.is_picture()
                });
                first.map_or(ImageColor::of(state), |(_, color)| color.kept_as(state))
            }
        };
        Some(if kept.is_picture() { self.changed(node, kept) } else { kept })
    }

    fn changed(&self, node: usize, kept: ImageColor) -> ImageColor {
        let mut colorimetry = kept.colorimetry;
        match self.changes[node] {
            ColorChange::Keep | ColorChange::Refit { .. } => {}
            ColorChange::ToDisplay => {
                colorimetry.primaries = widest(&self.displays[node]).map_or(Chromaticities::REC709, |d| d.primaries);
            }
            ColorChange::Display(primaries) => colorimetry.primaries = primaries,
            ColorChange::Encode(encoded) => {
                let adopted_white = colorimetry.adopted_white;
                colorimetry = encoded;
                colorimetry.adopted_white = encoded.adopted_white.or(adopted_white);
            }
            ColorChange::Adapt(white) => colorimetry.adopted_white = Some(white),
        }
        ImageColor { colorimetry, ..kept }
    }
}
