//! Puts files together into one module that a device can run.
//!
//! Each file has a namespace of its own: its declarations may have any names, also those of other files and of the
//! language. A name stays as its author wrote it where no other file of the module has it; elsewhere it gets the file's
//! name in front. All edits are of tokens; the text between them stays as it is, so that each byte of the result has a
//! place in a file.

mod contents;
mod edit;
mod emit;
mod instance;
mod linker;
mod loops;
mod names;
mod resolve;
mod source_map;
mod work;

pub use instance::Instance;
pub(crate) use linker::Declared;
pub use linker::{Linked, Linker};
pub(crate) use source_map::GENERATED;
pub use source_map::SourceMap;
pub(crate) use work::check_work;
