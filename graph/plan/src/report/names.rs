//! The names of all images and buffers of a plan.

use crate::plan::Plan;
use afterimage_graph::node::{BlockId, ImageId, Resource};

/// The names of all images and buffers of a plan.
pub(super) struct Names {
    pub(super) images: Vec<String>,
    buffers: Vec<String>,
    blocks: Vec<(BlockId, String)>,
}

impl Names {
    pub(super) fn new(plan: &Plan) -> Self {
        let blocks = plan.blocks.iter().map(|planned| (planned.id, planned.name.clone())).collect();
        Self { images: plan.image_names(), buffers: plan.buffer_names(), blocks }
    }

    pub(super) fn of(&self, resource: Resource) -> &str {
        match resource {
            Resource::Image(image) => self.image(image),
            Resource::Buffer(buffer) => &self.buffers[buffer.0 as usize],
        }
    }

    /// The names of the buffers, by number.
    pub(super) fn buffers(&self) -> impl Iterator<Item = &str> {
        self.buffers.iter().map(String::as_str)
    }

    /// The name of a block that some pass reads.
    pub(super) fn block(&self, block: BlockId) -> &str {
        let found = self.blocks.iter().find(|(id, _)| *id == block);
        &found.expect("a plan lists the blocks that its passes read").1
    }

    pub(super) fn image(&self, image: ImageId) -> &str {
        &self.images[image.0 as usize]
    }
}
