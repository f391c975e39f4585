//! A judge of plans that shares no code with the planner: it replays a plan and proves that every read sees its last write, that no two live
//! images share memory, and that barriers separate all that must be ordered.
//!
//! It reads nothing but the plan's data, and takes none of the planner's word: lifetimes, states and figures are found anew.

mod figures;
mod memory;
mod order;
mod states;

use std::collections::BTreeMap;

use crate::Plan;
use afterimage_graph::node::{Resource, Work};

/// Something in a plan that is wrong: a sentence with the names of the passes and images.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fault(String);

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Fault {}

/// Replays the plan.
///
/// # Errors
/// Every fault that was found, in the order of the walk; a plan whose lists do not fit together is not walked any further.
pub fn verify(plan: &Plan) -> Result<(), Vec<Fault>> {
    let mut faults = Faults::default();
    order::check_shape(plan, &mut faults);
    if faults.0.is_empty() {
        let walk = Walk::new(plan);
        order::check(&walk, &mut faults);
        memory::check(&walk, &mut faults);
        states::check(&walk, &mut faults);
        figures::check(&walk, &mut faults);
    }
    if faults.0.is_empty() { Ok(()) } else { Err(faults.0) }
}

/// What has been found.
#[derive(Default)]
struct Faults(Vec<Fault>);

impl Faults {
    fn add(&mut self, sentence: String) {
        self.0.push(Fault(sentence));
    }
}

/// A plan, with what follows from its passes and batches alone.
struct Walk<'a> {
    plan: &'a Plan,
    images: Vec<String>,
    buffers: Vec<String>,
    passes: Vec<String>,
    /// The batch of each pass.
    batch_of: Vec<usize>,
    /// What each pass reads and writes.
    accesses: Vec<Vec<Access>>,
    /// First and last batch of each image that a pass mentions.
    spans: Vec<Option<(usize, usize)>>,
}

/// One pass's dealings with one resource.
#[derive(Clone, Copy)]
struct Access {
    resource: Resource,
    reads: bool,
    writes: bool,
}

impl<'a> Walk<'a> {
    fn new(plan: &'a Plan) -> Self {
        let accesses: Vec<Vec<Access>> = plan.recording.passes.iter().map(|pass| accesses(&pass.work)).collect();
        let mut batch_of = vec![0; accesses.len()];
        for (batch, passes) in plan.batches.iter().enumerate() {
            batch_of[passes.clone()].fill(batch);
        }
        let mut spans = vec![None; plan.recording.images.len()];
        for (access, batch) in
            accesses.iter().zip(&batch_of).flat_map(|(all, batch)| all.iter().map(move |a| (a, *batch)))
        {
            if let Resource::Image(image) = access.resource {
                let (first, last) = spans[image.0 as usize].unwrap_or((batch, batch));
                spans[image.0 as usize] = Some((first.min(batch), last.max(batch)));
            }
        }
        let (images, buffers, passes) = (plan.image_names(), plan.buffer_names(), plan.pass_names());
        Self { plan, images, buffers, passes, batch_of, accesses, spans }
    }

    fn name(&self, resource: Resource) -> &str {
        match resource {
            Resource::Image(image) => &self.images[image.0 as usize],
            Resource::Buffer(buffer) => &self.buffers[buffer.0 as usize],
        }
    }

    /// Everything that happens to each resource: pass and access, in the order of execution.
    fn histories(&self) -> BTreeMap<Resource, Vec<(usize, Access)>> {
        let mut histories: BTreeMap<Resource, Vec<(usize, Access)>> = BTreeMap::new();
        for (pass, accesses) in self.accesses.iter().enumerate() {
            for access in accesses {
                histories.entry(access.resource).or_default().push((pass, *access));
            }
        }
        histories
    }
}

fn accesses(work: &Work) -> Vec<Access> {
    let mut found: BTreeMap<Resource, Access> = BTreeMap::new();
    let mut note = |resource: Resource, reads: bool, writes: bool| {
        let access = found.entry(resource).or_insert(Access { resource, reads: false, writes: false });
        access.reads |= reads;
        access.writes |= writes;
    };
    match work {
        Work::Steps { steps, result } => {
            steps
                .iter()
                .flat_map(|step| &step.args)
                .filter_map(|arg| arg.resource())
                .for_each(|r| note(r, true, false));
            note(Resource::Image(*result), false, true);
        }
        Work::Tiled(tiling) => {
            for stage in &tiling.stages {
                let args = stage.steps.iter().flat_map(|step| &step.args);
                args.filter_map(|arg| arg.resource()).for_each(|r| note(r, true, false));
                stage.result.iter().for_each(|image| note(Resource::Image(*image), false, true));
            }
        }
        Work::Rows(rows) => {
            let args = rows.source.iter().flat_map(|step| &step.args);
            args.filter_map(|arg| arg.resource()).for_each(|r| note(r, true, false));
            note(Resource::Image(rows.result), false, true);
        }
        Work::Cells(cells) => {
            let bindings = cells.readers.iter().flat_map(|reader| &reader.call.bindings);
            bindings.for_each(|b| note(b.resource, b.reads, b.writes));
        }
        Work::Entry(call) => call.bindings.iter().for_each(|b| note(b.resource, b.reads, b.writes)),
    }
    found.into_values().collect()
}
