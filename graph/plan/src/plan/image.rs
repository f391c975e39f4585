//! Images of a plan and their memory.

use afterimage_base::image::{ImageDesc, Signedness};
use afterimage_graph::node::Origin;
use afterimage_wgsl::SampleMode;
use serde::Serialize;

use crate::options::Alias;
use crate::request::Requirement;

/// An image with everything that the plan states about it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedImage {
    /// `node.port`, for people.
    #[serde(skip)]
    pub label: String,
    pub desc: ImageDesc,
    pub origin: Origin,
    /// The negative numbers that it may hold.
    pub signedness: Signedness,
    pub sample_mode: SampleMode,
    /// Its first and last batch; `None` if no pass uses it.
    pub lifetime: Option<Lifetime>,
    /// Size and alignment on the device, if it shares memory.
    pub requirement: Option<Requirement>,
    /// Its offset in the heap in bytes, if it shares memory.
    pub offset: Option<u64>,
    /// The texture of the pool that holds it, if it shares memory.
    pub slot: Option<u32>,
}

/// The batches in which an image is in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Lifetime {
    pub first: usize,
    /// The last batch; past the end for what leaves the frame.
    pub last: usize,
}

/// A pooled texture that images with equal descriptions share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Slot {
    pub desc: ImageDesc,
}

/// The shared memory of the transient images, and what sharing saves.
///
/// Images that leave the frame, histories, constants and what the host gives have memory of their own. Two images share
/// memory only if no batch mentions both, so that the barrier between two batches separates them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Memory {
    /// Textures of the pool; one for each image where images do not share.
    #[serde(skip)]
    pub slots: Vec<Slot>,
    /// Bytes of the heap that the plan uses.
    pub placed: u64,
    /// Bytes if every image that the nodes describe had its own texture, those included that fusion has removed.
    pub unaliased: u64,
    /// Bytes if each image that this plan stores had its own texture.
    pub unshared: u64,
    /// Bytes of the pool if images with equal descriptions share textures.
    pub pooled: u64,
    /// The most bytes that live at once: no placement of this order needs less.
    pub lower_bound: u64,
    /// Bytes of images that leave the frame or outlive it, which share nothing.
    pub kept: u64,
}

impl Memory {
    /// Bytes of transient images under that way of sharing.
    pub fn bytes(&self, alias: Alias) -> u64 {
        match alias {
            Alias::None => self.unshared,
            Alias::Pool => self.pooled,
            Alias::Placed => self.placed,
        }
    }
}
