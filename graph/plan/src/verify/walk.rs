//! A plan, with what follows from its passes and batches alone.

use std::collections::BTreeMap;

use crate::heap_placement::HeapPlacement;
use crate::plan::Plan;
use afterimage_graph::node::{Arg, Load, Pass, PassKind, Resource, Subresource};

/// Something in a plan that is wrong: a sentence with the names of the passes and images.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[error("{0}")]
pub struct Fault(String);

#[derive(Default)]
pub(super) struct Faults(pub(super) Vec<Fault>);

impl Faults {
    pub(super) fn add(&mut self, sentence: String) {
        self.0.push(Fault(sentence));
    }
}

/// A plan, with what follows from its passes and batches alone.
pub(super) struct Walk<'a> {
    pub(super) plan: &'a Plan,
    pub(super) places: &'a HeapPlacement,
    pub(super) images: Vec<String>,
    pub(super) buffers: Vec<String>,
    pub(super) passes: Vec<String>,
    /// The batch of each pass.
    pub(super) batch_of: Vec<usize>,
    /// Reads and writes of each pass.
    pub(super) accesses: Vec<Vec<Access>>,
    /// First and last batch of each image that a pass mentions.
    pub(super) spans: Vec<Option<(usize, usize)>>,
}

/// The use of one resource by one pass.
#[derive(Clone, Copy)]
pub(super) struct Access {
    pub(super) resource: Resource,
    pub(super) reads: bool,
    pub(super) writes: bool,
}

impl<'a> Walk<'a> {
    pub(super) fn new(plan: &'a Plan, places: &'a HeapPlacement) -> Self {
        let accesses: Vec<Vec<Access>> = plan.passes.iter().map(|planned| accesses(&planned.pass)).collect();
        let mut batch_of = vec![0; accesses.len()];
        for (number, batch) in plan.batches.iter().enumerate() {
            batch_of[batch.passes.clone()].fill(number);
        }
        let spans = spans(&accesses, &batch_of, plan.images.len());
        let (images, buffers, passes) = (plan.image_names(), plan.buffer_names(), plan.pass_names());
        Self { plan, places, images, buffers, passes, batch_of, accesses, spans }
    }

    pub(super) fn name(&self, resource: Resource) -> &str {
        match resource {
            Resource::Image(image) => &self.images[image.0 as usize],
            Resource::Buffer(buffer) => &self.buffers[buffer.0 as usize],
        }
    }

    /// Everything that the passes do: pass and access, in the order of execution.
    pub(super) fn uses(&self) -> impl Iterator<Item = (usize, Access)> + '_ {
        let uses = self.accesses.iter().enumerate();
        uses.flat_map(|(pass, accesses)| accesses.iter().map(move |access| (pass, *access)))
    }

    /// Everything that happens to each resource, likewise.
    pub(super) fn histories(&self) -> BTreeMap<Resource, Vec<(usize, Access)>> {
        let mut histories: BTreeMap<Resource, Vec<(usize, Access)>> = BTreeMap::new();
        self.uses().for_each(|(pass, access)| histories.entry(access.resource).or_default().push((pass, access)));
        histories
    }
}

/// First and last batch of each image.
fn spans(accesses: &[Vec<Access>], batch_of: &[usize], images: usize) -> Vec<Option<(usize, usize)>> {
    let mut spans = vec![None; images];
    for (accesses, batch) in accesses.iter().zip(batch_of) {
        for image in accesses.iter().filter_map(|access| access.resource.image()) {
            let (first, last) = spans[image.0 as usize].unwrap_or((*batch, *batch));
            spans[image.0 as usize] = Some((first.min(*batch), last.max(*batch)));
        }
    }
    spans
}

fn accesses(pass: &Pass) -> Vec<Access> {
    let mut found: BTreeMap<Resource, Access> = BTreeMap::new();
    let mut note = |resource: Resource, reads: bool, writes: bool| {
        let access = found.entry(resource).or_insert(Access { resource, reads: false, writes: false });
        access.reads |= reads;
        access.writes |= writes;
    };
    for arg in pass.kernels.iter().flat_map(|kernel| &kernel.args) {
        match arg.value {
            Arg::Pixel(image) | Arg::Texture(image) | Arg::Level(Subresource { image, .. }) => {
                note(Resource::Image(image), true, false);
            }
            Arg::Storage(image) => note(Resource::Image(image), false, true),
            Arg::Value(buffer, _) => note(Resource::Buffer(buffer), true, false),
            Arg::Buffer(buffer, writes) => note(Resource::Buffer(buffer), true, writes),
            Arg::Kernel(_) | Arg::Square | Arg::SquareOf(_) | Arg::Around | Arg::Zero(_) => {}
            Arg::Sampler | Arg::Point | Arg::PointOf(_) | Arg::Frame => {}
            Arg::Faults(_) | Arg::Invocation | Arg::Block(_) | Arg::Params => {}
        }
    }
    pass.results.iter().for_each(|result| note(Resource::Image(result.image), false, true));
    if let PassKind::Drawing(drawing) = &pass.kind {
        for color in &drawing.colors {
            note(Resource::Image(color.target.image), color.load == Load::Keep, true);
        }
        if let Some(depth) = &drawing.depth {
            note(Resource::Image(depth.target.image), depth.test.load == Load::Keep, true);
        }
        let buffers = drawing.geometry().into_iter().flat_map(|geometry| geometry.buffers());
        buffers.for_each(|buffer| note(Resource::Buffer(buffer), true, false));
    }
    found.into_values().collect()
}
