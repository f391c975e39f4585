//! Shaders as values: a module of WGSL, what it declares, and how modules are put together.

mod cells;
mod compose;
mod features;
mod horizontal;
mod import;
mod lints;
mod reflect;
mod rows;
mod tiles;
mod uniform;

use std::sync::OnceLock;

pub use cells::CELLS_LANES;
pub use compose::{Composed, SampleMode, ShaderError, Slot, SlotKind, compose_pass};
pub(crate) use compose::{STEPS_LANES, steps_cover};
pub use features::ShaderFeatures;
pub(crate) use horizontal::can_tell;
pub use horizontal::{Beside, UNIFORM_ALIGNMENT, compose_beside};
pub use import::SourceMap;
pub use reflect::{
    ArgType, EntryPoint, Function, Global, GlobalKind, Member, Reflection, ScalarKind, StructLayout, Told,
};
pub use rows::ROW_LANES;
pub(crate) use tiles::TILE_LANES;
pub use uniform::{UniformValue, pack};

/// One file of WGSL.
pub struct Shader {
    file: &'static str,
    source: &'static str,
    unchecked: bool,
    reflection: OnceLock<Result<Reflection, ShaderError>>,
}

impl Shader {
    /// A module with the name of its file, as errors shall show it.
    pub const fn new(file: &'static str, source: &'static str) -> Self {
        Self { file, source, unchecked: false, reflection: OnceLock::new() }
    }

    /// A module that may run without the checks of indices and loops that a driver otherwise adds to it, and beside others in one dispatch: its
    /// bindings then stand on lines of their own, and the names that it declares are given to nothing else ([`contract`](crate::node::contract())
    /// tries it).
    ///
    /// # Safety
    ///
    /// Whatever its inputs and parameters hold, NaN and the largest integers among them, every index into an array and every texel that is
    /// loaded must lie inside, every loop must end, and no memory of a workgroup may be read before it is written.
    #[allow(unsafe_code, reason = "the promise is the author's, and breaking it is undefined behaviour on the device")]
    pub const unsafe fn unchecked(file: &'static str, source: &'static str) -> Self {
        Self { file, source, unchecked: true, reflection: OnceLock::new() }
    }

    /// Whether the module was made by [`unchecked`](Self::unchecked).
    pub fn is_unchecked(&self) -> bool {
        self.unchecked
    }

    /// The file's name.
    pub fn file(&self) -> &'static str {
        self.file
    }

    /// The text of the file.
    pub fn source(&self) -> &'static str {
        self.source
    }

    /// What the module declares; parsed and validated once.
    pub fn reflect(&self) -> Result<&Reflection, ShaderError> {
        self.reflection.get_or_init(|| reflect::reflect(self)).as_ref().map_err(Clone::clone)
    }

    /// The invocations of a workgroup of an entry point; 1 for one that it does not have.
    pub(crate) fn lanes(&self, entry: &str) -> u32 {
        let known = self.reflect().ok().and_then(|known| known.entry(entry));
        known.map_or(1, |entry| entry.workgroup.iter().product())
    }

    /// Whether the module reads textures by itself and not through `texel` and `tap`, so that the framework cannot guard what it reads.
    pub fn reads_textures_itself(&self) -> bool {
        ["textureLoad", "textureSample", "textureGather"].iter().any(|call| self.source.contains(call))
    }
}

impl PartialEq for Shader {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || (self.file == other.file && self.source == other.source)
    }
}

impl std::fmt::Debug for Shader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Shader({})", self.file)
    }
}
