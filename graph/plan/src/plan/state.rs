//! State: what a frame leaves for later frames.

use std::collections::BTreeSet;

use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Resource};

use super::{Plan, PlannedPass};

/// Something that a frame leaves for later frames: a buffer that outlives frames, or an image that a later frame reads.
#[derive(Clone, Debug, PartialEq)]
pub struct StateItem {
    /// Its name in the plan, `node.port`; unique among the items.
    pub name: String,
    /// What it is.
    pub content: StateContent,
    /// How many frames before this one it is made from, where the other items are given. `None` where it is made from
    /// its own past, which may reach back to the first frame.
    pub reach: Option<u32>,
}

/// What an item of the state is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateContent {
    /// A buffer.
    Buffer {
        /// The buffer.
        buffer: BufferId,
        /// Its size in bytes.
        bytes: u64,
    },
    /// The images of the last frames.
    History {
        /// The image that is written in each frame.
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
    /// What a frame leaves for later frames: buffers first, then histories, each in the order of the plan. Empty if
    /// every frame depends on its own images only.
    pub fn state(&self) -> Vec<StateItem> {
        let mut items = Vec::new();
        for (index, (buffer, name)) in self.buffers.iter().zip(self.buffer_names()).enumerate() {
            if buffer.life == BufferLife::Persistent {
                let content = StateContent::Buffer { buffer: BufferId(index as u32), bytes: buffer.bytes };
                items.push(StateItem { name, content, reach: None });
            }
        }
        for (index, (image, name)) in self.images.iter().zip(self.image_names()).enumerate() {
            let id = ImageId(index as u32);
            if let Some(frames) = self.frames_remembered(id) {
                let content = StateContent::History { image: id, desc: image.desc, frames };
                items.push(StateItem { name, content, reach: (!self.is_made_from_the_past(id)).then_some(frames) });
            }
        }
        items
    }

    /// How many frames of an image are remembered; `None` if no pass reads an earlier one.
    fn frames_remembered(&self, image: ImageId) -> Option<u32> {
        let read = self.images.iter().filter(|past| past.lifetime.is_some());
        let frames = read.filter_map(|past| match past.origin {
            Origin::Previous { of, frames } if of == image => Some(frames),
            _ => None,
        });
        frames.max()
    }

    /// Whether an image is made from an image of an earlier frame. A buffer that outlives frames is an item of its own.
    fn is_made_from_the_past(&self, image: ImageId) -> bool {
        let mut needed = BTreeSet::from([image]);
        let mut needed_buffers = BTreeSet::new();
        for PlannedPass { pass, .. } in self.passes.iter().rev() {
            let is_needed = pass.writes().into_iter().any(|resource| match resource {
                Resource::Image(image) => needed.contains(&image),
                Resource::Buffer(buffer) => needed_buffers.contains(&buffer),
            });
            if !is_needed {
                continue;
            }
            for resource in pass.reads() {
                match resource {
                    Resource::Image(image) => drop(needed.insert(image)),
                    Resource::Buffer(buffer) if self.buffers[buffer.0 as usize].life == BufferLife::Persistent => {}
                    Resource::Buffer(buffer) => drop(needed_buffers.insert(buffer)),
                }
            }
        }
        needed.iter().any(|image| self.image(*image).origin.previous_of().is_some())
    }
}
