//! The meaning of the images on all wires: color states and colorimetry, along the wires that are really in use.
//!
//! The displays that images are encoded for are found first, against the wires. Then the colorimetry of each image
//! follows along the wires. Only nodes that an output needs count.

use std::collections::BTreeSet;

use petgraph::algo::toposort;

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

    /// The displays and files that the results of a node are encoded for.
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

    /// The meaning of all images along the wires in use: `resolve` says where a wire begins once nodes are replaced by
    /// their fallbacks; `None` for an image that is black, or nothing.
    pub fn colors_along(&self, resolve: &dyn Fn(Source) -> Option<Source>) -> ImageColors {
        let mut flow = Flow::new(self, resolve);
        flow.find_displays();
        flow.find_colors();
        ImageColors { inputs: flow.inputs, outputs: flow.outputs, displays: flow.displays }
    }
}

struct Flow<'a> {
    graph: &'a Graph,
    resolve: &'a dyn Fn(Source) -> Option<Source>,
    changes: Vec<ColorChange>,
    /// The nodes that an output needs, each after those that it reads in the same frame.
    order: Vec<usize>,
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
            displays: vec![BTreeSet::new(); graph.nodes.len()],
            inputs: graph.inputs.iter().map(|input| ImageColor::of(input.state)).collect(),
            outputs: graph.nodes.iter().map(|node| vec![None; node.kind().outputs().len()]).collect(),
        };
        flow.order = flow.needed();
        flow
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

    /// Against the wires, and once more where wires of earlier frames form cycles.
    fn find_displays(&mut self) {
        let mut is_changed = true;
        while std::mem::take(&mut is_changed) {
            for node in self.order.clone().into_iter().rev() {
                let displays = self.displays_before(node);
                let sources: Vec<Source> = self.arriving(node).map(|(_, source)| source).collect();
                for source in sources {
                    let Source::Node { node, .. } = source else { continue };
                    let known = self.displays[node].len();
                    self.displays[node].extend(&displays);
                    is_changed |= self.displays[node].len() > known;
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

    /// Along the wires, and once more where wires of earlier frames form cycles.
    fn find_colors(&mut self) {
        // A round fixes at least one further output, or none is left.
        for _ in 0..=self.order.len() {
            let mut is_changed = false;
            for node in self.order.clone() {
                let colors = self.colors_of(node);
                is_changed |= std::mem::replace(&mut self.outputs[node], colors.clone()) != colors;
            }
            if !is_changed {
                break;
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
                let first = arriving.find(|(port, color)| port.ty == PortType::Image && color.is_picture());
                first.map_or(ImageColor::of(state), |(_, color)| color.kept_as(state))
            }
        };
        Some(if kept.is_picture() { self.changed(node, kept) } else { kept })
    }

    fn changed(&self, node: usize, kept: ImageColor) -> ImageColor {
        let mut colorimetry = kept.colorimetry;
        match self.changes[node] {
            ColorChange::Keep | ColorChange::Refit { .. } => {}
            ColorChange::ToDisplay => colorimetry.primaries = widest(&self.displays[node]),
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

/// The primaries of the largest triangle in xy; Rec.709 if there is no display.
fn widest(displays: &BTreeSet<Colorimetry>) -> Chromaticities {
    let area = |primaries: &Chromaticities| {
        let [red, green, blue] = [primaries.red, primaries.green, primaries.blue].map(|xy| xy.to_vec());
        (green - red).perp_dot(blue - red).abs()
    };
    // Equal areas are compared by their coordinates, so that the order of the wires does not matter.
    let all = displays.iter().map(|display| display.primaries);
    all.max_by(|a, b| area(a).total_cmp(&area(b)).then(a.cmp(b))).unwrap_or(Chromaticities::REC709)
}
