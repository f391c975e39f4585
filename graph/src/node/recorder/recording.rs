//! What nodes have recorded.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::node::pass::Pass;
use crate::node::resource::{BufferId, ImageId, VirtualBuffer, VirtualImage};

/// The images, buffers and passes that nodes have recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// The images, by [`ImageId`].
    pub images: Vec<VirtualImage>,
    /// The buffers, by [`BufferId`].
    pub buffers: Vec<VirtualBuffer>,
    /// The passes, in the order in which they were recorded.
    pub passes: Vec<Pass>,
    /// The bytes of [computed](crate::node::Recorder::computed) images, by their labels.
    pub computed: BTreeMap<String, Arc<[u8]>>,
    /// The bytes that computed images may have together, if that is limited. What exceeds them is not computed: it is
    /// all zeros, and whoever sets the limit does not run the recording.
    pub most_computed: Option<u64>,
}

impl Recording {
    /// The image with that id.
    pub fn image(&self, id: ImageId) -> &VirtualImage {
        &self.images[id.0 as usize]
    }

    /// The buffer with that id.
    pub fn buffer(&self, id: BufferId) -> &VirtualBuffer {
        &self.buffers[id.0 as usize]
    }

    /// Adds an image.
    pub fn add_image(&mut self, image: VirtualImage) -> ImageId {
        self.images.push(image);
        ImageId(self.images.len() as u32 - 1)
    }

    /// Adds a buffer.
    pub fn add_buffer(&mut self, buffer: VirtualBuffer) -> BufferId {
        self.buffers.push(buffer);
        BufferId(self.buffers.len() as u32 - 1)
    }
}
