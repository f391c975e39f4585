//! The graph with fallbacks in the place of nodes that do not run.

use std::collections::BTreeMap;

use afterimage_graph::check::Source;
use afterimage_graph::node::{InputValues, OutputUse};

use crate::plan::Skipped;

/// The source of a wire once fallbacks are in place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WireSource {
    /// An output of a node, or an image or block of the host.
    From(Source),
    /// Zero everywhere.
    Zero,
    Absent,
}

/// The graph with fallbacks in place.
pub(crate) struct SpecializedGraph {
    /// The order in which nodes can be recorded.
    pub(crate) order: Vec<usize>,
    pub(crate) runs: Vec<bool>,
    /// For each node and output port, what its readers get.
    pub(super) outputs: Vec<Vec<WireSource>>,
    /// For each input, true if the host provides it.
    pub(super) given: Vec<bool>,
    /// For each node and output port, how much of it the outputs of the pipeline need.
    pub(crate) used_outputs: Vec<Vec<OutputUse>>,
    /// Nodes that do not run, and why.
    pub(crate) skipped: Vec<Skipped>,
    /// Nodes with dynamic parameters whose outputs equal their fallbacks at their values: what arrives, and of each
    /// output whether its fallback replaces it.
    pub(crate) identities: BTreeMap<usize, (InputValues, Vec<bool>)>,
}

impl SpecializedGraph {
    /// The source of a wire.
    pub(crate) fn resolve(&self, wire: Option<Source>) -> WireSource {
        match wire {
            None => WireSource::Absent,
            Some(Source::Input(input)) if !self.given[input] => WireSource::Absent,
            Some(source @ (Source::Input(_) | Source::Node { previous: 1.., .. })) => WireSource::From(source),
            Some(Source::Node { node, output, .. }) => self.outputs[node][output],
        }
    }

    /// The origin of a wire, unless it is absent or known to be black.
    pub(crate) fn source(&self, wire: Source) -> Option<Source> {
        match self.resolve(Some(wire)) {
            WireSource::From(source) => Some(source),
            WireSource::Zero | WireSource::Absent => None,
        }
    }

    /// Returns whether a node runs and an output needs it.
    pub(crate) fn is_live(&self, node: usize) -> bool {
        self.runs[node] && self.used_outputs[node].iter().any(|used| *used != OutputUse::Unused)
    }
}
