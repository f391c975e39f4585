//! Placed memory: one allocation in which images of any format and size lie at the plan's offsets.
//!
//! wgpu allocates memory for every texture it creates, so this needs the interface below it. It is there for Vulkan; on
//! other backends every image has memory of its own. Images whose memory overlaps are never alive at the same time: the
//! plan states this, and its verification proves it. The executor orders two images in the same memory by an explicit
//! transition (see [`Executor`](crate::Executor)).

use std::sync::Arc;

use afterimage_graph::image::ImageDesc;
use afterimage_plan::Requirement;

use crate::store::Stored;
use backend::Heap;
use requirements::MemoryRequirements;
#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
use unplaced as backend;
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
use vulkan as backend;

mod requirements;
#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
mod unplaced;
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
mod vulkan;

/// The images of a plan in a heap with their offsets, in the order of the plan's images. Images of equal description at
/// the same offset are one texture, so wgpu inserts the barrier between them by itself.
#[derive(Clone)]
pub(crate) struct Placed {
    pub(crate) heap: Arc<Heap>,
    pub(crate) images: Vec<(u64, Stored)>,
}

impl Placed {
    /// Creates images at the given offsets of one heap of `bytes` bytes. The old heap is reused if it has this size and
    /// a suitable memory type, and so are its images that have the same offset and description. `None` where the
    /// backend cannot place images, has no memory for the heap, or asks for more than the plan was made with.
    pub(crate) fn new(device: &wgpu::Device, bytes: u64, places: &[Place<'_>], old: Option<&Self>) -> Option<Self> {
        let types = places.iter().try_fold(u32::MAX, |types, place| {
            let asked = backend::requirements(device, &place.desc)?;
            place.suits(&asked).then_some(types & asked.memory_types)
        })?;
        let old = old.filter(|old| old.heap.bytes == bytes && types & (1 << old.heap.memory_type) != 0);
        let heap = match old {
            Some(old) => old.heap.clone(),
            None => Arc::new(Heap::new(device, bytes, types)?),
        };
        let old = old.map_or(&[][..], |old| &old.images);
        let mut images: Vec<(u64, Stored)> = Vec::with_capacity(places.len());
        for Place { offset, desc, label, .. } in places {
            let is_same = |(at, stored): &&(u64, Stored)| at == offset && stored.desc == *desc;
            let known = images.iter().chain(old).find(is_same).map(|(_, stored)| stored.clone());
            images.push((*offset, known.or_else(|| heap.place(*desc, *offset, label))?));
        }
        Some(Self { heap, images })
    }
}

/// The place of an image of a plan.
pub(crate) struct Place<'p> {
    pub(crate) offset: u64,
    pub(crate) desc: ImageDesc,
    /// The requirement that the plan was made with. The real one may be larger: the plan may be of another device, or
    /// the driver had no answer.
    pub(crate) planned: Requirement,
    pub(crate) label: &'p str,
}

impl Place<'_> {
    fn suits(&self, asked: &MemoryRequirements) -> bool {
        asked.bytes <= self.planned.bytes && self.offset.is_multiple_of(asked.alignment)
    }
}

/// The memory requirement that the driver states for an image; a typical requirement where the backend cannot be asked.
pub fn requirement(device: &wgpu::Device, desc: &ImageDesc) -> Requirement {
    match backend::requirements(device, desc) {
        Some(asked) => Requirement { bytes: asked.bytes, alignment: asked.alignment },
        None => Requirement::typical(desc),
    }
}
