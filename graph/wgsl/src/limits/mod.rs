//! Limits of untrusted shaders: the files of node kinds in folders.
//!
//! A short text can take a parser or a driver any amount of time, memory or stack. Each limit has its place here, and
//! `nodes/README.md` lists it.

mod cost;
mod memory;
mod merged;
mod text;

pub use cost::CompileCost;
pub(crate) use cost::{check_cost, compile_costs};
pub(crate) use memory::check_memory;
pub(crate) use text::{check_size, check_text};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// Name of what is counted, in the plural.
    pub counts: &'static str,
    pub max: usize,
}

impl Limit {
    const fn new(max: usize, counts: &'static str) -> Self {
        Self { counts, max }
    }

    /// Message if a count exceeds the limit.
    pub fn exceeded(&self, count: usize) -> Option<String> {
        (count > self.max).then(|| format!("too many {}: the limit is {}", self.counts, self.max))
    }
}

pub const FILE_BYTES: Limit = Limit::new(1 << 18, "bytes in a file");
/// Of all `.wgsl` files of a folder.
pub const FILES: Limit = Limit::new(64, "`.wgsl` files in a folder");
/// Of each file. Comments are no tokens.
pub const FILE_TOKENS: Limit = Limit::new(1 << 16, "tokens in a file");
/// Names that a file imports, and paths in its code.
pub const IMPORTS: Limit = Limit::new(256, "imports in a file");
/// Brackets, and operators in front of what they apply to.
pub const NESTING: Limit = Limit::new(64, "nested brackets and prefix operators");
/// Of an expression with the expressions around it, and of a chain of `else if`.
pub const OPERATORS: Limit = Limit::new(256, "operators in an expression");
/// Of a kind's files and what they use of the library.
pub const DECLARATIONS: Limit = Limit::new(1024, "declarations in the files of a kind");
/// Of a constant or a type, with those that it uses counted at each use.
pub const VALUE_TOKENS: Limit = Limit::new(1 << 17, "tokens in a constant or type and all that it uses");
/// Of each type, and thus of each constant and value.
pub const VALUE_BYTES: Limit = Limit::new(1 << 16, "bytes in a value");
/// Of a function, with those that it calls counted at each call. Arrays in constants do not count.
pub const ARRAY_BYTES: Limit = Limit::new(1 << 10, "bytes in array variables of a function and all that it calls");
/// Of a function, with those that it calls counted at each call, since drivers inline all calls. An operation counts
/// for each component, and what drivers write out counts more: see `cost.rs`. So do values that branches have made.
pub const OPERATIONS: Limit = Limit::new(96_000, "operations in a function and all that it calls");
/// Of a function, with those that it calls counted at each call: llvmpipe takes twice as long for each further one.
pub const LOOPS: Limit = Limit::new(10, "loops in a function and all that it calls");
pub const CALLS: Limit = Limit::new(64, "calls inside of calls");
/// Of a function that shares memory with the other invocations of its workgroup: all variables that it uses, as every
/// device has them.
pub const WORKGROUP_BYTES: Limit = Limit::new(1 << 14, "bytes of workgroup memory");
/// Of a function, with those that it calls counted at each call.
pub const BARRIERS: Limit = Limit::new(16, "barriers in a function and all that it calls");
/// Of a function with a workgroup, as every device has them.
pub const INVOCATIONS: Limit = Limit::new(256, "invocations in a workgroup");
/// Of all loops in one call of a kernel function. What runs longer ends there; `lib/loops.wgsl` counts.
pub const LOOP_STEPS: Limit = Limit::new(1 << 20, "steps of loops for a pixel");
/// The same on a processor: Mesa's driver (22) ends all loops of an invocation after 65535 steps, and does not say so.
pub const PROCESSOR_LOOP_STEPS: Limit = Limit::new(1 << 15, "steps of loops for a pixel on a processor");
/// The same of a function with a workgroup: its invocations wait for each other, one by one where they add to a number.
pub const WORKGROUP_LOOP_STEPS: Limit = Limit::new(1 << 14, "steps of loops for a pixel with a workgroup");
/// Of a kind without Rust.
pub const PARAMETERS: Limit = Limit::new(64, "parameters of a kind");
/// Of a kind without Rust. A device binds at least 16 textures in a pass.
pub const INPUTS: Limit = Limit::new(12, "inputs of a kind");
/// Of a kind without Rust. Each has a function, which a driver compiles.
pub const IMAGES: Limit = Limit::new(8, "images of a kind");
/// Of a kind without Rust.
pub const OUTPUTS: Limit = Limit::new(8, "outputs of a kind");
/// Of a function of a kind without Rust. A device binds at least 16 textures in a pass.
pub const TEXTURES: Limit = Limit::new(12, "textures that a function reads");

/// Stack of a thread that parses shaders: the parsers of naga recurse, by up to [`OPERATORS`] expressions.
pub const STACK_BYTES: usize = 64 << 20;
