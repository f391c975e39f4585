//! The planner as the list of its stages.

use std::collections::BTreeSet;

use afterimage_graph::check::Graph;

use crate::bake::bake;
use crate::barriers::barriers;
use crate::codegen::{blocks, codegen};
use crate::crop::rectangles;
use crate::cull::cull;
use crate::dynamic_nodes::{DynamicNodes, DynamicRecords};
use crate::error::PlanError;
use crate::fault_counters::add_fault_counters;
use crate::formats::{Formatted, formats};
use crate::fusion::fusion;
use crate::limits::{MAX_COMPUTED_BYTES, MAX_OPERATIONS};
use crate::memory::memory;
use crate::options::Alias;
use crate::plan::{Memory, Plan, PlannedPass};
use crate::record::record;
use crate::refresh::{cache_results, refresh};
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

/// Makes a plan for inspection, which must not run: tables that nodes compute have their sizes but hold zeros. To
/// compute one table takes 0.1 s or more; all other stages of most plans together take less than 0.01 s.
///
/// # Errors
/// As [`plan`].
pub fn plan_without_tables(graph: &Graph, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
    Ok(plan_with_tables_up_to(graph, request, 0)?.0)
}

/// Makes the plan of a graph, and what it takes to change its [dynamic](PlanRequest::dynamic) parameters while it runs.
///
/// # Errors
/// As [`plan`].
pub fn plan_dynamic(graph: &Graph, request: &PlanRequest<'_>) -> Result<(Plan, DynamicNodes), PlanError> {
    plan_with_tables_up_to(graph, request, MAX_COMPUTED_BYTES)
}

/// Runs the stages. Computed tables of more than `max_computed_bytes` hold zeros.
fn plan_with_tables_up_to(
    graph: &Graph,
    request: &PlanRequest<'_>,
    max_computed_bytes: u64,
) -> Result<(Plan, DynamicNodes), PlanError> {
    let specialized = specialize(graph, request)?;
    let mut builder = record(graph, request, &specialized, max_computed_bytes)?;
    // The stages below change the recording, but dynamic nodes are recorded again into what it is now.
    let dynamic_nodes = std::mem::take(&mut builder.dynamic);
    let dynamic_records = DynamicRecords::new(dynamic_nodes, specialized.identities, &builder.recording);
    cull(&mut builder);
    cache_results(&mut builder);
    if request.options.count_faults {
        add_fault_counters(&mut builder);
    }
    sanitize(&mut builder, &request.caps);
    bake(&mut builder, graph, request);
    fusion(&mut builder, request);
    // From here on the options are those that this device can follow.
    let Formatted { mut passes, mut images, options } = formats(&mut builder, request)?;
    refresh(&mut passes, &images, &builder);
    let schedule = schedule(passes, &images, builder.recording.buffers.len(), &options);
    let memory = memory(&mut images, &schedule, &builder, request, options.alias);
    check_memory(&memory, options.alias, request)?;
    let (batches, exports) = barriers(&schedule, &images, &builder, options.alias);
    let passes = codegen(schedule.passes, &images);
    check_operations(&passes)?;
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
        savings: builder.savings,
        dynamic: request.dynamic.iter().map(|parameter| graph.parameter_name(*parameter)).collect(),
        size: request.given.size,
        options,
    };
    plan.rectangles = rectangles(graph, request, &plan);
    let dynamic = dynamic_records.into_nodes(graph, request, &plan);
    Ok((plan, dynamic))
}

/// An error if a driver would compile the passes for minutes. Equal passes are compiled once.
fn check_operations(passes: &[PlannedPass]) -> Result<(), PlanError> {
    let mut known = BTreeSet::new();
    let mut operations: usize = 0;
    for PlannedPass { pass, .. } in passes {
        let kernels = pass.kernels.iter();
        let code: Vec<_> = kernels.map(|kernel| (kernel.shader.file(), &*kernel.function, &kernel.defines)).collect();
        if known.insert(code) {
            operations = operations.saturating_add(pass.compile_cost().operations());
        }
    }
    if operations > MAX_OPERATIONS { Err(PlanError::TooManyOperations(operations)) } else { Ok(()) }
}

/// An error if the images of a frame have more memory than the device may give.
fn check_memory(memory: &Memory, alias: Alias, request: &PlanRequest<'_>) -> Result<(), PlanError> {
    let given = request.given.inputs.values().map(|image| image.desc.bytes());
    let bytes = given.fold(memory.bytes(alias).saturating_add(memory.kept), u64::saturating_add);
    let limit = request.caps.max_memory;
    if bytes > limit { Err(PlanError::TooMuchMemory { bytes, limit }) } else { Ok(()) }
}
