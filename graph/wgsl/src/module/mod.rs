//! The declarations of a file and the names that they use, from its tokens.

mod declaration;
mod import;
mod kind;
mod scope;
mod syntax;
mod wrong;

pub use declaration::imports;
pub(crate) use declaration::{Declaration, Import, Module, Symbol, Use};
pub(crate) use kind::DeclarationKind;
