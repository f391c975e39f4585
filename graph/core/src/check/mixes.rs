//! Images that a node mixes must have one color state and one colorimetry.

use super::Graph;
use super::draft::DraftGraph;
use super::reports::Reports;
use crate::node::{ImageColor, Input};
use afterimage_base::color::Colorimetry;
use afterimage_base::diagnostic::{Diagnostic, Location, quote};

/// A mix of two images that do not fit together: where each of them is wired, and what it is.
struct Mix {
    node: usize,
    first: (usize, ImageColor),
    second: (usize, ImageColor),
}

impl DraftGraph {
    /// Reports the nodes whose inputs accept the same states, so that their images are mixed, and get images that a sum
    /// has no meaning for.
    pub(super) fn agree_on_colors(&self, graph: &Graph, reports: &mut Reports) {
        mixes(graph).iter().for_each(|mix| reports.push(self.mix_conflict(mix)));
    }

    fn mix_conflict(&self, mix: &Mix) -> Diagnostic {
        let draft = &self.nodes[mix.node];
        let port = |index: usize| quote(&draft.kind.inputs()[index].name);
        let ((first, a), (second, b)) = (mix.first, mix.second);
        let message =
            format!("{} mixes {} and {}, which differ in color", quote(&draft.name.value), port(first), port(second));
        let label = |index: usize, color: ImageColor| format!("{} is {}", port(index), described(color));
        Diagnostic::error("color-conflict", message)
            .at(self.wired_at(mix.node, second), label(second, b))
            .also(self.wired_at(mix.node, first), label(first, a))
            .help("mix the images where both have the same color state, for one display")
    }

    fn wired_at(&self, node: usize, input: usize) -> &Location {
        let draft = &self.nodes[node];
        draft.wires[input].as_ref().map_or(&draft.kind_location, |wire| &wire.location)
    }
}

fn mixes(graph: &Graph) -> Vec<Mix> {
    let colors = graph.colors();
    let mut mixes = Vec::new();
    for (node, found) in graph.nodes.iter().enumerate() {
        let wired = found.kind().inputs().iter().zip(&found.wires).enumerate();
        let known = wired.filter_map(|(index, (port, wire))| Some((index, port, colors.at((*wire)?)?)));
        let pictures: Vec<(usize, &Input, ImageColor)> = known.filter(|(.., color)| color.is_picture()).collect();
        let [(first, port, color), others @ ..] = pictures.as_slice() else { continue };
        let second = others.iter().find(|(_, other, found)| {
            !port.states.is_empty() && other.states == port.states && !color.mixes_with(found)
        });
        mixes.extend(second.map(|(second, _, wrong)| Mix { node, first: (*first, *color), second: (*second, *wrong) }));
    }
    mixes
}

fn described(color: ImageColor) -> String {
    let Colorimetry { primaries, transfer, .. } = color.colorimetry;
    let space = primaries.name().unwrap_or("its own primaries");
    match color.colorimetry.transfer == ImageColor::of(color.state).colorimetry.transfer {
        true => format!("{} in {space}", quote(color.state.name())),
        false => format!("{} by {transfer:?} in {space}", quote(color.state.name())),
    }
}
