//! Shaders as values: files of WGSL, what they declare, and the linker that puts them together.

#![allow(missing_docs, reason = "no host uses this crate, and authors of nodes only `Shader` and `Library` of it")]

#[cfg(not(target_family = "wasm"))]
mod back_end;
mod banded;
mod barriers;
mod direct_reads;
mod entry;
mod error;
mod library;
pub mod limits;
mod link;
mod lints;
mod module;
mod naga_error;
mod reflect;
mod sample_mode;
mod shader;
mod shader_cost;
mod token;
mod uniform;
mod validate;
mod walk;

pub use banded::{BandedModule, banded};
pub use entry::{EntryPoint, EntryStage, Located, NumberKind};
pub use error::{Place, ShaderError, ShaderLabel};
pub use library::{Library, Source};
pub use link::{Instance, Linked, Linker, SourceMap};
pub use module::imports;
pub use reflect::{ArgType, Function, Global, GlobalKind, Member, Reflection, ScalarKind, StructLayout};
pub use sample_mode::SampleMode;
pub use shader::Shader;
pub use shader_cost::{RegisterPressure, ShaderCost};
pub use uniform::UniformValue;
pub use validate::validate;

/// Returns whether a name is that of a type of WGSL, such as `vec4f`: a function of that name hides the type.
pub fn is_type_name(name: &str) -> bool {
    naga::front::wgsl::parse_str(&format!("alias Same = {name};")).is_ok()
}

/// Returns whether a name may be declared in a module: WGSL does not reserve it.
pub fn is_free_name(name: &str) -> bool {
    naga::front::wgsl::parse_str(&format!("fn f({name}: f32) {{ }} struct S {{ {name}: f32 }}")).is_ok()
}
