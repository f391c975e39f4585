//! Virtual images and buffers: what passes read and write.

use std::sync::Arc;

use afterimage_base::hash::fnv1a;
use afterimage_base::image::{ImageDesc, Signedness};
use serde::{Serialize, Serializer};

/// A virtual image of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ImageId(pub u32);

/// A virtual buffer of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct BufferId(pub u32);

/// A host block, by the index of its input in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct BlockId(pub u32);

/// An image or a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Resource {
    /// An image.
    Image(ImageId),
    /// A buffer.
    Buffer(BufferId),
}

impl Resource {
    /// The image; `None` for a buffer.
    pub fn image(self) -> Option<ImageId> {
        match self {
            Self::Image(image) => Some(image),
            Self::Buffer(_) => None,
        }
    }
}

/// Origin of an image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Origin {
    /// Made and used within one frame; its memory is shared with others.
    Transient,
    /// Given by the host under this name.
    Input(String),
    /// Filled once, when the plan is set up.
    Constant(#[serde(serialize_with = "hash_of")] Arc<[u8]>),
    /// Made in some frames, and kept in the others: a table that is made after a change of uniforms, or the result of a
    /// node that does not run in every frame.
    Retained,
    /// The image `of` of so many frames ago.
    Previous {
        /// The image that is written in each frame.
        of: ImageId,
        /// Number of frames back.
        frames: u32,
    },
}

impl Origin {
    /// The image whose contents of an earlier frame it shows, if it does.
    pub fn previous_of(&self) -> Option<ImageId> {
        match self {
            Self::Previous { of, .. } => Some(*of),
            _ => None,
        }
    }
}

/// A virtual image: a description, and how it lives.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualImage {
    /// `node.port`, for people.
    pub label: String,
    /// Size and format.
    pub desc: ImageDesc,
    /// Its source.
    pub origin: Origin,
    /// True if all its numbers are known to be finite and within half range.
    pub finite: bool,
    /// The negative numbers that it may hold.
    pub signedness: Signedness,
}

/// A virtual buffer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VirtualBuffer {
    /// `node.name`, for people.
    #[serde(skip)]
    pub label: String,
    /// Its size.
    pub bytes: u64,
    /// Lifetime.
    pub life: BufferLife,
}

/// Lifetime of a buffer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum BufferLife {
    /// Written before it is read in every frame.
    Frame,
    /// All zero at the start of every frame.
    Zeroed,
    /// Keeps its contents from frame to frame; all zero at first and after a reset.
    Persistent,
    /// Filled once, when the plan is set up.
    Constant(#[serde(serialize_with = "hash_of")] Arc<[u8]>),
}

/// Contents as JSON shows them: by their hash.
fn hash_of<S: Serializer>(bytes: &Arc<[u8]>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{:032x}", fnv1a(bytes)))
}
