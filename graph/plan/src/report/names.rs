//! The names of all images and buffers of a plan.

use crate::plan::Plan;
use afterimage_graph::node::{ImageId, Resource};

/// The names of all images and buffers of a plan.
pub(super) struct Names {
    pub(super) images: Vec<String>,
    pub(super) buffers: Vec<String>,
}

impl Names {
    pub(super) fn new(plan: &Plan) -> Self {
        Self { images: plan.image_names(), buffers: plan.buffer_names() }
    }

    pub(super) fn of(&self, resource: Resource) -> &str {
        match resource {
            Resource::Image(image) => self.image(image),
            Resource::Buffer(buffer) => &self.buffers[buffer.0 as usize],
        }
    }

    pub(super) fn image(&self, image: ImageId) -> &str {
        &self.images[image.0 as usize]
    }
}
