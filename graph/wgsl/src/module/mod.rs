//! The declarations of a file and the names that they use, from its tokens.

mod declaration;
mod kind;
mod scope;
mod syntax;

pub(crate) use declaration::{Declaration, Module, Symbol, Use};
pub(crate) use kind::DeclarationKind;
