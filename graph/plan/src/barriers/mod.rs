//! Barriers: what must happen between two batches, for every image and buffer.

mod aliasing;

use std::collections::BTreeMap;

use crate::builder::PlanBuilder;
use crate::options::Alias;
use crate::plan::{Batch, PlannedImage, ScheduledPass, Stage, Transition, Use};
use crate::schedule::Schedule;
use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Resource, VirtualBuffer};

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
        let uses = schedule.passes[passes.clone()].iter().flat_map(uses_of).collect();
        batches.push(Batch { passes: passes.clone(), transitions: states.enter(uses), aliasing });
    }
    let outputs = builder.outputs.iter().map(|output| (Resource::Image(output.image), Use::Host)).collect();
    (batches, states.enter(outputs))
}

/// The use of each resource of a pass; a write takes precedence over a read.
fn uses_of(scheduled: &ScheduledPass) -> BTreeMap<Resource, Use> {
    let ScheduledPass { pass, stage, .. } = scheduled;
    let mut uses: BTreeMap<Resource, Use> = pass.reads().into_iter().map(|resource| (resource, Use::Read)).collect();
    for resource in pass.writes() {
        let write = match (resource, stage) {
            (Resource::Buffer(_), _) => Use::StorageReadWrite,
            (Resource::Image(image), Stage::Drawing)
                if pass.drawing().is_some_and(|drawing| drawing.is_depth(image)) =>
            {
                Use::DepthAttachment
            }
            (Resource::Image(_), Stage::Fragment | Stage::Drawing) => Use::ColorAttachment,
            (Resource::Image(_), Stage::Compute) => Use::StorageWrite,
        };
        uses.insert(resource, write);
    }
    uses
}

/// The present use of everything.
struct States(BTreeMap<Resource, Use>);

impl States {
    fn new(images: &[PlannedImage], buffers: &[VirtualBuffer]) -> Self {
        let mut states = BTreeMap::new();
        for (image, id) in images.iter().zip(0..) {
            states.insert(Resource::Image(ImageId(id)), of_image(&image.origin));
        }
        for (buffer, id) in buffers.iter().zip(0..) {
            states.insert(Resource::Buffer(BufferId(id)), of_buffer(&buffer.life));
        }
        Self(states)
    }

    /// Changes the uses to these; the transitions that it takes.
    fn enter(&mut self, uses: BTreeMap<Resource, Use>) -> Vec<Transition> {
        uses.into_iter().filter_map(|(resource, to)| self.change(resource, to)).collect()
    }

    fn change(&mut self, resource: Resource, to: Use) -> Option<Transition> {
        let from = self.0.insert(resource, to).expect("everything has a use");
        (from != to || to.writes()).then_some(Transition { resource, from, to })
    }
}

/// The use of an image at the beginning of a frame.
fn of_image(origin: &Origin) -> Use {
    match origin {
        Origin::Transient => Use::Undefined,
        Origin::Input(_) | Origin::Constant(_) => Use::Host,
        Origin::Previous { .. } | Origin::Retained => Use::PreviousFrame,
    }
}

/// The use of a buffer at the beginning of a frame.
fn of_buffer(life: &BufferLife) -> Use {
    match life {
        BufferLife::Frame => Use::Undefined,
        BufferLife::Zeroed | BufferLife::Constant(_) => Use::Host,
        BufferLife::Persistent => Use::PreviousFrame,
    }
}
