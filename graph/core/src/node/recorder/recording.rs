//! Recordings of nodes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::node::kernel::{Arg, KernelCall};
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
    pub max_computed: Option<u64>,
    /// The nodes whose state stays as it is once it is made.
    pub settled: BTreeSet<String>,
}

/// A pixel of an image that has another size than the result of the function that takes it.
#[derive(Clone, Copy, Debug)]
pub struct MisfitPixel<'r> {
    /// The function.
    pub kernel: &'r KernelCall,
    /// The argument's name.
    pub argument: &'r str,
    /// The image of the pixel.
    pub image: ImageId,
    /// The image of the result.
    pub result: ImageId,
}

impl Recording {
    /// Reads of a pass outside of an image, or at other places of it: pixels of images of another size.
    pub fn misfit_pixels<'r>(&'r self, pass: &'r Pass) -> impl Iterator<Item = MisfitPixel<'r>> {
        let result = pass.results.first().map(|result| result.image);
        let args = pass.kernels.iter().flat_map(|kernel| kernel.args.iter().map(move |argument| (kernel, argument)));
        args.filter_map(move |(kernel, argument)| match (argument.value, result) {
            (Arg::Pixel(image), Some(result)) if self.image(image).desc.size != self.image(result).desc.size => {
                Some(MisfitPixel { kernel, argument: &argument.name, image, result })
            }
            _ => None,
        })
    }

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
