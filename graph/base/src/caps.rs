//! What a device can do, as plain data: the planner asks this and never the device.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::image::Format;

/// What plans may rely on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Caps {
    /// Formats that compute shaders can store to.
    pub storage: BTreeSet<Format>,
    /// Formats that fragment shaders can draw to.
    pub renderable: BTreeSet<Format>,
    /// Whether 32-bit floats can be filtered.
    pub filter_32_bit: bool,
    /// The longest side of an image.
    pub max_side: u32,
    /// The longest side of a volume.
    pub max_volume_side: u32,
    /// Workgroup memory in bytes.
    pub workgroup_bytes: u32,
    /// Invocations in one workgroup.
    pub workgroup_invocations: u32,
    /// The largest storage buffer in bytes.
    pub max_buffer: u64,
    /// Storage images in one pass.
    pub max_storage_images: u32,
    /// Whether shaders have half-precision arithmetic.
    pub half_arithmetic: bool,
    /// Whether shaders have subgroup operations.
    pub subgroups: bool,
    /// Whether a dispatch costs so much beside arithmetic that chains of images are made in workgroup memory.
    pub tiles: bool,
    /// Whether point and gather passes draw instead of dispatching.
    pub prefer_fragment: bool,
}

impl Default for Caps {
    /// What every WebGPU device has.
    fn default() -> Self {
        Self {
            storage: [Format::Rgba8Unorm, Format::Rgba16Float, Format::R32Float, Format::Rgba32Float].into(),
            renderable: [
                Format::Rgba8Unorm,
                Format::R16Float,
                Format::Rg16Float,
                Format::Rgba16Float,
                Format::R32Float,
                Format::Rgba32Float,
            ]
            .into(),
            filter_32_bit: false,
            max_side: 8192,
            max_volume_side: 2048,
            workgroup_bytes: 16 * 1024,
            workgroup_invocations: 256,
            max_buffer: 128 << 20,
            max_storage_images: 4,
            half_arithmetic: false,
            subgroups: false,
            tiles: false,
            prefer_fragment: false,
        }
    }
}
