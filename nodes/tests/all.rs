//! Tests of the built-in kinds that need no device: nodes with color files, and combinations of parameters.
#![allow(missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod color_files;
mod eetf;
mod readme;
mod tone_map;
