//! The planner as the list of its stages.

use afterimage_graph::check::Graph;

use crate::barriers::barriers;
use crate::codegen::codegen;
use crate::cull::cull;
use crate::error::PlanError;
use crate::formats::{Formatted, formats};
use crate::fusion::fusion;
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
/// An input that the host does not give, an image that is too large for the device, an output without an image, or sizes
/// of histories that do not settle.
pub fn plan(graph: &Graph, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
    let specialized = specialize(graph, request)?;
    let mut builder = record(graph, request, &specialized)?;
    cull(&mut builder);
    sanitize(&mut builder);
    fusion(&mut builder, request);
    let Formatted { passes, mut images, options, ignored } = formats(&mut builder, request)?;
    let schedule = schedule(passes, &images, builder.recording.buffers.len(), &options);
    let memory = memory(&mut images, &schedule, &builder, (request, &options));
    let (batches, exports) = barriers(&schedule, &images, &builder, options.alias);
    let passes = codegen(schedule.passes, &images, &options);
    Ok(Plan {
        images,
        buffers: builder.recording.buffers,
        passes,
        batches,
        exports,
        memory,
        inputs: builder.inputs,
        outputs: builder.outputs,
        skipped: builder.skipped,
        ignored,
        fused: builder.fused,
        shared_reads: builder.shared_reads,
        size: request.size,
        options,
    })
}
