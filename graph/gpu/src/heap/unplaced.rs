//! Targets without Vulkan: no image is placed.

use afterimage_graph::image::ImageDesc;

use super::requirements::MemoryRequirements;
use crate::store::Stored;

/// No heap exists.
pub(crate) struct Heap {
    pub(super) bytes: u64,
    pub(super) memory_type: u32,
}

impl Heap {
    /// No memory can be placed.
    pub(super) fn new(_device: &wgpu::Device, _bytes: u64, _memory_types: u32) -> Option<Self> {
        None
    }

    /// No image can be placed.
    pub(super) fn place(&self, _desc: ImageDesc, _offset: u64, _label: &str) -> Option<Stored> {
        None
    }
}

/// The backend cannot be asked.
pub(super) fn requirements(_device: &wgpu::Device, _desc: &ImageDesc) -> Option<MemoryRequirements> {
    None
}
