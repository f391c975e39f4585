//! Specialization: which nodes run. Nodes that are off, that change nothing at their present values, or that no output
//! needs are replaced by their fallbacks or left out.

mod fallbacks;
mod specialized_graph;
mod used_outputs;

use afterimage_graph::check::Graph;

use crate::error::PlanError;
use crate::request::PlanRequest;

pub(crate) use specialized_graph::{SpecializedGraph, WireSource};

/// Decides which nodes run for this request, and which of their outputs are needed.
pub(crate) fn specialize(graph: &Graph, request: &PlanRequest<'_>) -> Result<SpecializedGraph, PlanError> {
    let mut specialized = fallbacks::put_fallbacks(graph, request);
    used_outputs::mark_used_outputs(graph, &mut specialized)?;
    Ok(specialized)
}
