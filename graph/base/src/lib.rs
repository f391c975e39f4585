//! What every layer of Afterimage shares: parameter values, image descriptions, diagnostics and device capabilities.
//!
//! This crate reads no files, knows no device and depends on no other crate of the workspace.

pub mod caps;
pub mod diagnostic;
pub mod image;
pub mod value;
