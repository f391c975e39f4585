//! Barriers: what must happen between two batches, for every image and buffer.

mod aliasing;

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::PlanBuilder;
use crate::options::Alias;
use crate::plan::{Batch, PlannedImage, ScheduledPass, Stage, Transition, Use};
use crate::schedule::Schedule;
use afterimage_graph::node::{BufferLife, ImageId, Origin, Resource, VirtualBuffer};

pub(crate) use aliasing::aliasing;

/// The batches with their barriers, and the transitions of the outputs to the host.
pub(crate) fn barriers(
    schedule: &Schedule,
    images: &[PlannedImage],
    builder: &PlanBuilder,
    alias: Alias,
) -> (Vec<Batch>, Vec<Transition>) {
    let mut states = States::new(images, &builder.recording.buffers);
    let offsets: Vec<Option<u64>> = images.iter().map(|image| image.offset).collect();
    let aliasing = aliasing(images, &offsets, alias, schedule.batches.len());
    let mut batches = Vec::with_capacity(schedule.batches.len());
    for (passes, aliasing) in schedule.batches.iter().zip(aliasing) {
        let uses: BTreeMap<Resource, Use> = schedule.passes[passes.clone()].iter().flat_map(uses_of).collect();
        let transitions = uses.into_iter().filter_map(|(resource, to)| states.change(resource, to)).collect();
        batches.push(Batch { passes: passes.clone(), transitions, aliasing });
    }
    let outputs: BTreeSet<ImageId> = builder.outputs.iter().map(|output| output.image).collect();
    let exports = outputs.into_iter().filter_map(|image| states.change(Resource::Image(image), Use::Host));
    (batches, exports.collect())
}

/// How the pass uses its resources.
fn uses_of(scheduled: &ScheduledPass) -> BTreeMap<Resource, Use> {
    let ScheduledPass { pass, stage, .. } = scheduled;
    let mut uses: BTreeMap<Resource, Use> = pass.reads().into_iter().map(|resource| (resource, Use::Read)).collect();
    for resource in pass.writes() {
        let write = match (resource, stage) {
            (Resource::Buffer(_), _) => Use::StorageReadWrite,
            (Resource::Image(_), Stage::Fragment) => Use::ColorAttachment,
            (Resource::Image(_), Stage::Compute) => Use::StorageWrite,
        };
        uses.insert(resource, write);
    }
    uses
}

/// The present use of everything.
struct States {
    images: Vec<Use>,
    buffers: Vec<Use>,
}

impl States {
    fn new(images: &[PlannedImage], buffers: &[VirtualBuffer]) -> Self {
        let image = |origin: &Origin| match origin {
            Origin::Transient => Use::Undefined,
            Origin::Input(_) | Origin::Constant(_) => Use::Host,
            Origin::Previous { .. } => Use::PreviousFrame,
        };
        let buffer = |life: &BufferLife| match life {
            BufferLife::Frame => Use::Undefined,
            BufferLife::Zeroed | BufferLife::Constant(_) => Use::Host,
            BufferLife::Persistent => Use::PreviousFrame,
        };
        Self {
            images: images.iter().map(|i| image(&i.origin)).collect(),
            buffers: buffers.iter().map(|b| buffer(&b.life)).collect(),
        }
    }

    fn change(&mut self, resource: Resource, to: Use) -> Option<Transition> {
        let state = match resource {
            Resource::Image(image) => &mut self.images[image.0 as usize],
            Resource::Buffer(buffer) => &mut self.buffers[buffer.0 as usize],
        };
        let from = std::mem::replace(state, to);
        (from != to || to.writes()).then_some(Transition { resource, from, to })
    }
}
