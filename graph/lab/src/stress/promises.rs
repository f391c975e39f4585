//! What kinds promise beyond finite values: that a constant image stays constant, a symmetric one symmetric, and so on.
//!
//! Most built-in kinds make all promises, so these tables hold the exceptions, and the few promises that only some
//! kinds make. A kind that is not known promises neither constancy nor symmetry.

use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::value::Value;

/// Kinds whose effect depends on the position in the image, or on the sample: those of a constant image differ.
const PLACED: &[&str] = &[
    "DemoScene",
    "Dither",
    "FilmGrain",
    "Fog",
    "Gtao",
    "LensDirt",
    "LensFlare",
    "Resolve",
    "ShadowMask",
    "Ssao",
    "Streaks",
    "Vignette",
];
/// Kinds whose effect is not the same on the left and on the right.
const ASYMMETRIC: &[&str] = &[
    "BilateralBlur",
    "ChromaticAberration",
    "DemoScene",
    "Dither",
    "FilmGrain",
    "Fog",
    "Gtao",
    "HeatHaze",
    "LensDirt",
    "LensDistortion",
    "MotionBlur",
    "Resolve",
    "ShadowMask",
    "Ssao",
    "Taa",
];
/// Kinds that keep a constant image as it is.
const KEEPING: &[&str] = &[
    "BilateralBlur",
    "Cas",
    "ChromaticAberration",
    "Downsample",
    "Fxaa",
    "Gaussian",
    "GaussianPyramid",
    "Halation",
    "HeatHaze",
    "LensDistortion",
    "Sharpen",
    "Upsample",
];
/// Kinds that spread light without losing any.
const SPREADING: &[&str] = &["Gaussian"];
/// Monotone point kinds: more light never becomes less.
const RISING: &[&str] = &["Brightness", "Contrast", "Encode", "Exposure", "Saturation", "ToneMap", "WhiteBalance"];
/// Kinds whose history follows the brightness of the frames only.
const FOLLOWING: &[&str] = &["Adapt", "AutoExposure"];
/// Kinds that can give negative light.
const NEGATIVE: &[&str] = &["Cdl"];
/// Kinds that only make values visible.
const PROBES: &[&str] = &["ProbeFilter", "ProbeLevel", "ProbeValue", "ProbeVolume"];

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
    /// A rising ramp of grays comes out rising.
    pub(crate) rises: bool,
    /// Light may come out negative.
    pub(crate) negative: bool,
    /// Its history is an exposure that follows the brightness.
    pub(crate) follows: bool,
}

impl Promises {
    /// What all nodes of a graph promise together.
    pub(crate) fn of(graph: &Graph, known_kinds: &[&str]) -> Self {
        let is_real = |node: &&GraphNode| !PROBES.contains(&node.kind().name());
        let is_known = |node: &GraphNode| known_kinds.contains(&node.kind().name());
        let all = |promise: &dyn Fn(&GraphNode) -> bool| graph.nodes.iter().filter(is_real).all(promise);
        Self {
            constant: all(&|node| is_known(node) && !is_one_of(node, PLACED)),
            keeps: all(&keeps),
            symmetric: all(&|node| is_known(node) && !is_one_of(node, ASYMMETRIC)),
            spreads: all(&|node| is_one_of(node, SPREADING)),
            rises: all(&|node| is_one_of(node, RISING)),
            negative: graph.nodes.iter().any(|node| is_one_of(node, NEGATIVE)),
            follows: all(&is_known) && graph.nodes.iter().any(|node| is_one_of(node, FOLLOWING)),
        }
    }
}

fn is_one_of(node: &GraphNode, kinds: &[&str]) -> bool {
    kinds.contains(&node.kind().name())
}

fn keeps(node: &GraphNode) -> bool {
    // A sum of levels is brighter than each of them.
    let sums = node.instance.value("normalize") == Some(&Value::Bool(false))
        && node.instance.value("blend") == Some(&Value::Choice("Add"));
    is_one_of(node, KEEPING) && !sums
}
