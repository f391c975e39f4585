//! Step 6: what must happen between two batches, stated for every image and buffer.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use serde::Serialize;

use crate::{Alias, Lifetime, Memory, Plan, PlanOutput, Stage};
use afterimage_graph::node::{BufferLife, ImageId, Origin, Pass, Recording, Resource, Work};

/// How an image or a buffer is used; each use wants a state of its own from the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Use {
    /// Not used yet: what its memory holds does not matter.
    Undefined,
    /// Filled or taken by the host: inputs, outputs, constants, and buffers that are cleared at the start of the frame.
    Host,
    /// As an earlier frame has left it.
    Earlier,
    /// Read by shaders: a sampled texture, or a storage buffer that is only read.
    Read,
    /// Written by a dispatch: a storage texture.
    StorageWrite,
    /// Read and written by a dispatch: a storage buffer.
    StorageReadWrite,
    /// Drawn to.
    ColorAttachment,
}

impl Use {
    /// Whether the contents change.
    pub fn writes(self) -> bool {
        matches!(self, Self::StorageWrite | Self::StorageReadWrite | Self::ColorAttachment)
    }

    /// The name in plans.
    pub fn name(self) -> &'static str {
        match self {
            Self::Undefined => "Undefined",
            Self::Host => "Host",
            Self::Earlier => "Earlier",
            Self::Read => "Read",
            Self::StorageWrite => "StorageWrite",
            Self::StorageReadWrite => "StorageReadWrite",
            Self::ColorAttachment => "ColorAttachment",
        }
    }
}

/// A change of use, or a write after a write, which must be ordered though the use is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Transition {
    /// What is used.
    #[serde(skip)]
    pub resource: Resource,
    /// Its use before the batch.
    pub from: Use,
    /// Its use in the batch.
    pub to: Use,
}

/// Memory that changes hands: the new resident must be touched before the batch, because the device orders nothing between two textures
/// of one memory by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AliasingBarrier {
    /// The image whose life begins in this batch.
    pub image: ImageId,
    /// The images that were the last to use the memory, in ascending order.
    pub residents: Vec<ImageId>,
}

/// All that must happen before a batch runs: one batch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BatchBarriers {
    /// Changes of use, images before buffers, by number.
    pub transitions: Vec<Transition>,
    /// Memory that changes hands, by number.
    pub aliasing: Vec<AliasingBarrier>,
}

/// The barriers of all batches, and the transitions that hand the outputs to the host.
pub(crate) fn barriers(
    recording: &Recording,
    stages: &[Stage],
    batches: &[Range<usize>],
    outputs: &[PlanOutput],
) -> (Vec<BatchBarriers>, Vec<Transition>) {
    let mut states = States::new(recording);
    let mut barriers = Vec::with_capacity(batches.len());
    for batch in batches {
        let mut uses: BTreeMap<Resource, Use> = BTreeMap::new();
        for pass in batch.clone() {
            uses.extend(uses_of(&recording.passes[pass], stages[pass]));
        }
        let transitions = uses.into_iter().filter_map(|(resource, to)| states.change(resource, to)).collect();
        barriers.push(BatchBarriers { transitions, aliasing: Vec::new() });
    }
    let images: BTreeSet<ImageId> = outputs.iter().map(|output| output.image).collect();
    let exports = images.into_iter().filter_map(|image| states.change(Resource::Image(image), Use::Host));
    (barriers, exports.collect())
}

/// How the pass uses what it mentions.
fn uses_of(pass: &Pass, stage: Stage) -> BTreeMap<Resource, Use> {
    let mut uses: BTreeMap<Resource, Use> = pass.reads().into_iter().map(|resource| (resource, Use::Read)).collect();
    for resource in pass.writes() {
        let write = match (resource, stage, &pass.work) {
            (Resource::Buffer(_), ..) => Use::StorageReadWrite,
            (Resource::Image(_), Stage::Fragment, Work::Steps { .. }) => Use::ColorAttachment,
            (Resource::Image(_), ..) => Use::StorageWrite,
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
    fn new(recording: &Recording) -> Self {
        let image = |origin: &Origin| match origin {
            Origin::Transient => Use::Undefined,
            Origin::Input(_) | Origin::Constant(_) => Use::Host,
            Origin::Previous { .. } => Use::Earlier,
        };
        let buffer = |life: &BufferLife| match life {
            BufferLife::Frame => Use::Undefined,
            BufferLife::Zeroed | BufferLife::Constant(_) => Use::Host,
            BufferLife::Persistent => Use::Earlier,
        };
        Self {
            images: recording.images.iter().map(|i| image(&i.origin)).collect(),
            buffers: recording.buffers.iter().map(|b| buffer(&b.life)).collect(),
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

/// States anew whose memory changes hands before each batch: after a change of places.
pub(crate) fn renew_hand_overs(plan: &mut Plan) {
    for barriers in &mut plan.barriers {
        barriers.aliasing.clear();
    }
    hand_over(&mut plan.barriers, &plan.memory, &plan.lifetimes, plan.options.alias);
}

/// States whose memory changes hands before each batch.
pub(crate) fn hand_over(barriers: &mut [BatchBarriers], memory: &Memory, lifetimes: &[Option<Lifetime>], alias: Alias) {
    let mut arrivals: Vec<(usize, usize, Range<u64>)> = (0..lifetimes.len())
        .filter_map(|image| Some((lifetimes[image]?.first, image, extent(memory, alias, image)?)))
        .collect();
    arrivals.sort_by_key(|(first, image, _)| (*first, *image));
    let mut residents = Residents::default();
    for (batch, image, extent) in arrivals {
        let image = ImageId(image as u32);
        let before = residents.replace(extent, image);
        if !before.is_empty() {
            barriers[batch].aliasing.push(AliasingBarrier { image, residents: before });
        }
    }
}

/// What of the shared memory is the image's: bytes of the heap, or a texture of the pool.
fn extent(memory: &Memory, alias: Alias, image: usize) -> Option<Range<u64>> {
    match alias {
        Alias::None => None,
        Alias::Pool => memory.slot_of[image].map(|slot| u64::from(slot)..u64::from(slot) + 1),
        Alias::Placed => {
            let offset = memory.offset_of[image]?;
            memory.requirement_of[image].map(|requirement| offset..offset + requirement.bytes)
        }
    }
}

/// Who used each stretch of memory last: from its start to its end and the image.
#[derive(Default)]
struct Residents(BTreeMap<u64, (u64, ImageId)>);

impl Residents {
    /// Moves in and tells who was there.
    fn replace(&mut self, extent: Range<u64>, image: ImageId) -> Vec<ImageId> {
        let before_start = self.0.range(..extent.start).next_back().map(|(start, _)| *start);
        let first = before_start.filter(|start| self.0[start].0 > extent.start).unwrap_or(extent.start);
        let old: Vec<(u64, (u64, ImageId))> =
            self.0.range(first..extent.end).map(|(start, rest)| (*start, *rest)).collect();
        let mut residents = BTreeSet::new();
        for (start, (end, resident)) in old {
            residents.insert(resident);
            self.0.remove(&start);
            if start < extent.start {
                self.0.insert(start, (extent.start, resident));
            }
            if end > extent.end {
                self.0.insert(extent.end, (end, resident));
            }
        }
        self.0.insert(extent.start, (extent.end, image));
        residents.into_iter().collect()
    }
}
