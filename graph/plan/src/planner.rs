//! The planner as the list of its stages.

use afterimage_graph::check::Graph;

use crate::barriers::barriers;
use crate::codegen::{blocks, codegen};
use crate::crop::rectangles;
use crate::cull::cull;
use crate::dynamic::{DynamicNodes, DynamicRecords};
use crate::error::PlanError;
use crate::formats::{Formatted, formats};
use crate::fusion::fusion;
use crate::limits::MAX_COMPUTED_BYTES;
use crate::memory::memory;
use crate::plan::Plan;
use crate::record::record;
use crate::request::PlanRequest;
use crate::sanitize::sanitize;
use crate::schedule::schedule;
use crate::specialize::specialize;

/// Makes the plan of a graph.
///
/// # Errors
/// An input that the host does not give, an image that is too large for the device, an output without an image, or
/// sizes of histories that do not settle.
pub fn plan(graph: &Graph, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
    Ok(plan_dynamic(graph, request)?.0)
}

/// Makes a plan to look at and not to run: tables that nodes compute have their sizes, and zeros in the place of their
/// texels. A table takes a tenth of a second and more, and all else of most plans less than a hundredth.
///
/// # Errors
/// As [`plan`].
pub fn plan_without_tables(graph: &Graph, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
    Ok(plan_computing(graph, request, 0)?.0)
}

/// Makes the plan of a graph, and what it takes to change its [dynamic](PlanRequest::dynamic) parameters while it runs.
///
/// # Errors
/// As [`plan`].
pub fn plan_dynamic(graph: &Graph, request: &PlanRequest<'_>) -> Result<(Plan, DynamicNodes), PlanError> {
    plan_computing(graph, request, MAX_COMPUTED_BYTES)
}

/// The same, with zeros in the place of computed tables of more than `max_computed_bytes`.
fn plan_computing(
    graph: &Graph,
    request: &PlanRequest<'_>,
    max_computed_bytes: u64,
) -> Result<(Plan, DynamicNodes), PlanError> {
    let specialized = specialize(graph, request)?;
    let mut builder = record(graph, request, &specialized, max_computed_bytes)?;
    let settings = std::mem::take(&mut builder.dynamic);
    let records = DynamicRecords::new(settings, specialized.identities, &builder.recording);
    cull(&mut builder);
    sanitize(&mut builder);
    fusion(&mut builder, request);
    let Formatted { passes, mut images, options } = formats(&mut builder, request)?;
    let schedule = schedule(passes, &images, builder.recording.buffers.len(), &options);
    let memory = memory(&mut images, &schedule, &builder, request, options.alias);
    let (batches, exports) = barriers(&schedule, &images, &builder, options.alias);
    let passes = codegen(schedule.passes, &images);
    let mut plan = Plan {
        blocks: blocks(graph, &passes),
        images,
        buffers: builder.recording.buffers,
        passes,
        batches,
        exports,
        memory,
        rectangles: Vec::new(),
        inputs: builder.inputs,
        outputs: builder.outputs,
        skipped: builder.skipped,
        fused: builder.fused,
        shared_reads: builder.shared_reads,
        dynamic: request.dynamic.iter().map(|parameter| graph.parameter_name(*parameter)).collect(),
        size: request.given.size,
        options,
    };
    plan.rectangles = rectangles(graph, request, &plan);
    let dynamic = records.nodes(graph, request, &plan);
    Ok((plan, dynamic))
}
