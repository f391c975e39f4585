//! A module with its entry points and bindings.

use afterimage_base::Shared;
use afterimage_graph::node::{BufferId, ImageId};
use afterimage_wgsl::{SampleMode, ShaderError, SourceMap, validate};

/// What a binding slot of a composed module holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// `@binding`; all are in group 0.
    pub binding: u32,
    /// What it holds.
    pub kind: SlotKind,
}

/// The first binding that none of the slots has.
pub(crate) fn free(slots: &[Slot]) -> u32 {
    slots.iter().map(|slot| slot.binding + 1).max().unwrap_or(0)
}

/// The kinds of binding slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// The uniform with the frame's time and number.
    Frame,
    /// The pass's own uniform.
    Params,
    /// A uniform with the size of the result in texels: two floats. To ask the texture for it takes longer.
    Extent,
    /// The linear, clamping sampler.
    Sampler,
    /// A sampled image.
    Texture(ImageId),
    /// A storage image that is written.
    Storage(ImageId),
    /// A storage buffer, and whether it is written.
    Buffer(BufferId, bool),
}

/// A module that a device can run.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The text of the module.
    pub source: String,
    /// Where its lines come from.
    pub map: SourceMap,
    /// The compute entry point's name.
    pub compute: Shared<str>,
    /// The fragment entry point's name, with `vertex` as its vertex entry point, if it has one.
    pub fragment: Option<&'static str>,
    /// The bindings of the compute entry point. The fragment entry point has the same but the storage image.
    pub slots: Vec<Slot>,
    /// The workgroup's size.
    pub workgroup: [u32; 3],
    /// Whether every part of the module was unchecked: see [`Shader::unchecked`](afterimage_wgsl::Shader::unchecked).
    pub unchecked: bool,
    /// How its taps read textures.
    pub reading: SampleMode,
    /// Whether it may read workgroup memory that it has not written, which must then begin as zero.
    pub zero_workgroup_memory: bool,
}

impl Composed {
    /// Parses and validates the module.
    ///
    /// # Errors
    /// The first error, at the author's line.
    pub fn validate(&self) -> Result<naga::Module, ShaderError> {
        validate(&self.source, &self.map)
    }
}
