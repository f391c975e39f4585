//! What kinds promise beyond being finite: whether a constant image stays constant, a symmetric one symmetric.
//!
//! Most kinds promise all of it, so these tables hold the exceptions, and the few promises that only some make. A kind that this
//! program does not know promises neither constancy nor symmetry.

use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::value::Value;

/// Kinds whose effect depends on the place in the picture.
const PLACED: &[&str] = &["DemoScene", "Dither", "FilmGrain", "Vignette"];
/// Kinds whose effect is not the same on the left and on the right.
const LOPSIDED: &[&str] = &["DemoScene", "Dither", "FilmGrain"];
/// Kinds that give back the constant that they are given.
const KEEPING: &[&str] = &["Downsample", "Gaussian", "GaussianPyramid", "Upsample"];
/// Kinds that move light about and lose none of it.
const SPREADING: &[&str] = &["Gaussian"];
/// Kinds of one pixel each under which more light never becomes less.
const RISING: &[&str] = &["Brightness", "Contrast", "Encode", "Exposure", "Saturation", "ToneMap", "WhiteBalance"];
/// Kinds that follow the brightness of the frames over time, and nothing else.
const FOLLOWING: &[&str] = &["Adapt", "AutoExposure"];
/// Kinds that say that they may give negative light.
const NEGATIVE: &[&str] = &["Cdl"];
/// Kinds without any effect of their own here.
const PROBES: &[&str] = &["ProbeLevel", "ProbeValue", "ProbeVolume"];

/// The promises of a whole graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Promises {
    /// A constant image comes out constant.
    pub(crate) constant: bool,
    /// It comes out as the same constant.
    pub(crate) keeps: bool,
    /// A symmetric image comes out symmetric.
    pub(crate) symmetric: bool,
    /// The sum of all pixels stays the same, where nothing reaches the border.
    pub(crate) spreads: bool,
    /// A rising ramp of greys comes out rising.
    pub(crate) rises: bool,
    /// Light may come out negative.
    pub(crate) negative: bool,
    /// What it remembers is an exposure that follows the picture.
    pub(crate) follows: bool,
}

impl Promises {
    /// What all nodes of a graph promise together.
    pub(crate) fn of(graph: &Graph) -> Self {
        let known = |node: &&GraphNode| !PROBES.contains(&node.kind.name());
        let all = |promise: fn(&GraphNode) -> bool| graph.nodes.iter().filter(known).all(promise);
        Self {
            constant: all(|node| is_known(node) && !is_one_of(node, PLACED)),
            keeps: all(keeps),
            symmetric: all(|node| is_known(node) && !is_one_of(node, LOPSIDED)),
            spreads: all(|node| is_one_of(node, SPREADING)),
            rises: all(|node| is_one_of(node, RISING)),
            negative: graph.nodes.iter().any(|node| is_one_of(node, NEGATIVE)),
            follows: all(is_known) && graph.nodes.iter().any(|node| is_one_of(node, FOLLOWING)),
        }
    }
}

fn is_one_of(node: &GraphNode, kinds: &[&str]) -> bool {
    kinds.contains(&node.kind.name())
}

fn is_known(node: &GraphNode) -> bool {
    afterimage_nodes::ALL.iter().any(|kind| kind.name() == node.kind.name())
}

fn value<'n>(node: &'n GraphNode, parameter: &str) -> Option<&'n Value> {
    node.kind.param(parameter).map(|(index, _)| &node.values[index])
}

fn keeps(node: &GraphNode) -> bool {
    // A sum of levels is brighter than each of them.
    let sums =
        value(node, "normalize") == Some(&Value::Bool(false)) && value(node, "blend") == Some(&Value::Choice("Add"));
    is_one_of(node, KEEPING) && !sums
}
