//! Types that all layers of Afterimage share: parameter values, image descriptions, colorimetry, diagnostics, device
//! capabilities and SVG.
//!
//! This crate does no IO, accesses no device and depends on no other crate of the workspace.

pub mod bake;
pub mod caps;
pub mod color;
pub mod diagnostic;
mod file;
pub mod hash;
pub mod image;
pub mod panics;
mod shared;
pub mod svg;
pub mod value;

pub use shared::Shared;
