//! Shaders as values: a module of WGSL, what it declares, and how modules are put together.

mod error;
mod features;
mod import;
mod lints;
mod reflect;
mod sample_mode;
mod uniform;

use std::sync::OnceLock;

use afterimage_base::Shared;

pub use error::{ShaderError, validate};
pub use features::ShaderFeatures;
pub use import::{SourceMap, TILED, Text, bound_from, change_words, declared};
pub use reflect::{ArgType, EntryPoint, Function, Global, GlobalKind, Member, Reflection, ScalarKind, StructLayout};
pub use sample_mode::SampleMode;
pub use uniform::{UniformValue, pack};

/// Whether a name may be declared in a module: it is no word that WGSL reserves.
pub fn is_free_name(name: &str) -> bool {
    naga::front::wgsl::parse_str(&format!("fn f({name}: f32) {{ }} struct S {{ {name}: f32 }}")).is_ok()
}

/// One file of WGSL.
pub struct Shader {
    file: Shared<str>,
    source: Shared<str>,
    unchecked: bool,
    reflection: OnceLock<Result<Reflection, ShaderError>>,
}

impl Shader {
    /// A module with the name of its file, as errors shall show it.
    pub const fn new(file: &'static str, source: &'static str) -> Self {
        Self { file: Shared::of(file), source: Shared::of(source), unchecked: false, reflection: OnceLock::new() }
    }

    /// A module that is loaded when the program runs.
    pub fn loaded(file: String, source: String) -> Self {
        let (file, source) = (file.into(), source.into());
        Self { file, source, unchecked: false, reflection: OnceLock::new() }
    }

    /// A module that runs without the bounds checks of indices and loops that a driver otherwise adds to it.
    ///
    /// # Safety
    ///
    /// Whatever its inputs and parameters hold, NaN and the largest integers among them, every index into an array and every texel that is
    /// loaded must lie inside, every loop must end, and no memory of a workgroup may be read before it is written.
    #[allow(unsafe_code, reason = "the promise is the author's, and breaking it is undefined behaviour on the device")]
    pub const unsafe fn unchecked(file: &'static str, source: &'static str) -> Self {
        Self { file: Shared::of(file), source: Shared::of(source), unchecked: true, reflection: OnceLock::new() }
    }

    /// Whether the module was made by [`unchecked`](Self::unchecked).
    pub fn is_unchecked(&self) -> bool {
        self.unchecked
    }

    /// The file's name.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// A handle to the file's name.
    pub fn file_handle(&self) -> Shared<str> {
        self.file.clone()
    }

    /// The text of the file.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// What the module declares; parsed and validated once.
    pub fn reflect(&self) -> Result<&Reflection, ShaderError> {
        self.reflection.get_or_init(|| reflect::reflect(self)).as_ref().map_err(Clone::clone)
    }

    /// Whether the module reads textures by itself and not through `texel` and `tap`, so that the framework cannot sanitize what it reads.
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
