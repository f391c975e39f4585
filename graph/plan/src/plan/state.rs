//! State: what a frame leaves for later frames.

use std::collections::BTreeSet;

use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Resource};

use super::{Plan, PlannedPass};

/// Something that a frame leaves for later frames: a buffer that outlives frames, an image that a later frame reads, or
/// a cached result.
#[derive(Clone, Debug, PartialEq)]
pub struct StateItem {
    /// Its name in the plan, `node.port`; unique among the items.
    pub name: String,
    /// The buffer or images.
    pub content: StateContent,
    /// Number of earlier frames that it depends on, given the other items. `None` if it depends on
    /// its own past, which may reach back to the first frame.
    pub reach: Option<u32>,
}

/// The buffer or images of an item of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateContent {
    /// A buffer.
    Buffer {
        /// The buffer.
        buffer: BufferId,
        /// Its size in bytes.
        bytes: u64,
    },
    /// The images of the last frames, or the cached one.
    History {
        /// The image that is written in each frame, or in some.
        image: ImageId,
        /// Size and format of each.
        desc: ImageDesc,
        /// The number of frames that are remembered, from 1.
        frames: u32,
    },
}

impl StateItem {
    /// Kind, size and format in words: items with equal names and words fit each other.
    pub fn described(&self) -> String {
        match self.content {
            StateContent::Buffer { bytes, .. } => format!("{bytes} bytes"),
            StateContent::History { desc, frames, .. } => {
                let mut words = format!("{} {}", desc.size, desc.format.name());
                for (count, what) in [(desc.levels, "levels"), (desc.layers, "layers"), (desc.samples, "samples")] {
                    if count > 1 {
                        words += &format!(", {count} {what}");
                    }
                }
                let plural = if frames == 1 { "" } else { "s" };
                format!("{words}, {frames} frame{plural}")
            }
        }
    }
}

impl Plan {
    /// The state that a frame leaves for later frames: buffers first, then histories, each in plan order. Empty if
    /// every frame depends on its own images only.
    pub fn state(&self) -> Vec<StateItem> {
        let mut items = Vec::new();
        let cached = self.cached_results();
        let cached_for = |resource: Resource| cached.get(&resource)?.every().map(|every| every - 1);
        for (index, (buffer, name)) in self.buffers.iter().zip(self.buffer_names()).enumerate() {
            let id = BufferId(index as u32);
            let frames = cached_for(Resource::Buffer(id));
            if frames.is_some() || buffer.life == BufferLife::Persistent {
                let content = StateContent::Buffer { buffer: id, bytes: buffer.bytes };
                let reach = frames.filter(|_| !self.is_made_from_the_past(Resource::Buffer(id)));
                items.push(StateItem { name, content, reach });
            }
        }
        for (index, (image, name)) in self.images.iter().zip(self.image_names()).enumerate() {
            let id = ImageId(index as u32);
            let back = cached_for(Resource::Image(id));
            let remembered = self.frames_remembered(id);
            if let Some(frames) = remembered.or(back.and(Some(1))) {
                let content = StateContent::History { image: id, desc: image.desc, frames };
                let reach = remembered.unwrap_or(0) + back.unwrap_or(0);
                let reach = (!self.is_made_from_the_past(Resource::Image(id))).then_some(reach);
                items.push(StateItem { name, content, reach });
            }
        }
        items
    }

    /// Number of frames of an image that are kept; `None` if no pass reads an earlier one.
    fn frames_remembered(&self, image: ImageId) -> Option<u32> {
        let read = self.images.iter().filter(|past| past.lifetime.is_some());
        let frames = read.filter_map(|past| match past.origin {
            Origin::Previous { of, frames } if of == image => Some(frames),
            _ => None,
        });
        frames.max()
    }

    /// Returns whether something depends on an image of an earlier frame. Buffers that outlive frames, and cached
    /// results, are items of their own.
    fn is_made_from_the_past(&self, resource: Resource) -> bool {
        let mut needed = BTreeSet::from([resource]);
        let items = self.lasting_resources();
        for PlannedPass { pass, .. } in self.passes.iter().rev() {
            if pass.writes().iter().any(|resource| needed.contains(resource)) {
                needed.extend(pass.reads().into_iter().filter(|read| !items.contains(read)));
            }
        }
        needed.into_iter().any(|resource| self.is_of_earlier_frame(resource))
    }

    /// Buffers that outlive frames, and cached results.
    pub(super) fn lasting_resources(&self) -> BTreeSet<Resource> {
        let buffers = self.buffers.iter().zip(0..).filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
        let buffers = buffers.map(|(_, id)| Resource::Buffer(BufferId(id)));
        buffers.chain(self.cached_results().into_keys()).collect()
    }

    /// True for the image of an earlier frame.
    pub(super) fn is_of_earlier_frame(&self, resource: Resource) -> bool {
        resource.image().is_some_and(|image| self.image(image).origin.previous_of().is_some())
    }
}
