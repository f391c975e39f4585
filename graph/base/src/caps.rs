//! Device capabilities as plain data. The planner reads them and never accesses a device.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::image::Format;

/// The capabilities that a plan may use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Caps {
    /// Formats that compute shaders can store to.
    pub storage: BTreeSet<Format>,
    /// Formats that fragment shaders can draw to.
    pub renderable: BTreeSet<Format>,
    /// Formats that draws can blend into.
    pub blendable: BTreeSet<Format>,
    /// True if 32-bit floats can be filtered.
    pub filter_32_bit: bool,
    /// The longest side of an image.
    pub max_side: u32,
    /// The longest side of a volume.
    pub max_volume_side: u32,
    /// Invocations in one workgroup.
    pub workgroup_invocations: u32,
    /// The largest storage buffer in bytes.
    pub max_buffer: u64,
    /// The most bytes that the images of a frame may have together, those of the host included.
    pub max_memory: u64,
    /// Storage images in one pass.
    pub max_storage_images: u32,
    /// Uniform buffers in one pass, besides that of the frame's time and number.
    pub max_uniform_buffers: u32,
    /// The same in a pass that is fused of others: fewer where a driver fails with more.
    pub max_fused_uniform_buffers: u32,
    /// True if the ranges of draws that a buffer holds may begin at any instance; at the first otherwise.
    pub indirect_first_instance: bool,
    /// True if workgroup memory is faster than the device's other memory. It is not on a processor, where images are
    /// not halved row by row.
    pub fast_workgroup_memory: bool,
    /// True if point and gather passes are drawn instead of dispatched.
    pub prefer_fragment: bool,
}

impl Default for Caps {
    /// The capabilities of every WebGPU device.
    fn default() -> Self {
        Self {
            storage: [Format::Rgba8Unorm, Format::Rgba16Float, Format::R32Float, Format::Rgba32Float].into(),
            renderable: [
                Format::Rgba8Unorm,
                Format::R16Float,
                Format::Rg16Float,
                Format::Rgba16Float,
                Format::Rgb10a2Unorm,
                Format::R32Float,
                Format::Rgba32Float,
            ]
            .into(),
            blendable: [
                Format::Rgba8Unorm,
                Format::R16Float,
                Format::Rg16Float,
                Format::Rgba16Float,
                Format::Rgb10a2Unorm,
            ]
            .into(),
            filter_32_bit: false,
            max_side: 8192,
            max_volume_side: 2048,
            workgroup_invocations: 256,
            max_buffer: 128 << 20,
            max_memory: u64::MAX,
            max_storage_images: 4,
            max_uniform_buffers: 11,
            max_fused_uniform_buffers: 11,
            indirect_first_instance: false,
            fast_workgroup_memory: false,
            prefer_fragment: false,
        }
    }
}
