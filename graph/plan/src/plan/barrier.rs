//! Batches, transitions and aliasing barriers.

use std::ops::Range;

use afterimage_graph::node::{ImageId, Resource};
use serde::Serialize;

/// Passes that need no barrier between them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Batch {
    pub passes: Range<usize>,
    /// Changes of use before the batch, images before buffers, by number.
    pub transitions: Vec<Transition>,
    /// Memory that goes from one image to another before the batch, by number.
    pub aliasing: Vec<AliasingBarrier>,
}

/// The use of an image or a buffer; each use is a state of its own on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Use {
    /// Not used yet: what its memory holds does not matter.
    Undefined,
    /// Filled or taken by the host: inputs, outputs, constants, and buffers that are cleared at the start of the frame.
    Host,
    /// As the previous frame has left it.
    PreviousFrame,
    /// Read by shaders, a sampled texture or a storage buffer that is only read; or a buffer of vertices, of indices or
    /// of ranges of a draw.
    Read,
    /// Written by a dispatch: a storage texture.
    StorageWrite,
    /// Read and written by a dispatch: a storage buffer.
    StorageReadWrite,
    /// Drawn to.
    ColorAttachment,
    /// The depth of a drawing pass.
    DepthAttachment,
}

impl Use {
    /// Returns whether the contents change.
    pub fn writes(self) -> bool {
        matches!(self, Self::StorageWrite | Self::StorageReadWrite | Self::ColorAttachment | Self::DepthAttachment)
    }
}

/// A change of use, or a write after a write, which must be ordered though the use is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Transition {
    pub resource: Resource,
    /// Its use before the batch.
    pub from: Use,
    /// Its use in the batch.
    pub to: Use,
}

/// Memory that goes from one image to another. The device does not order uses of two textures that share memory, so the
/// batch needs an explicit barrier.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AliasingBarrier {
    /// The image whose life begins in this batch.
    pub image: ImageId,
    /// The images that used the memory last, in ascending order.
    pub owners: Vec<ImageId>,
}
