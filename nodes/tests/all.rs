//! Tests of the built-in kinds that need no device: files of look-up tables, and combinations of parameters.
#![allow(missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod clf;
mod color_files;
mod lut;
mod pipeline_files;
mod tone_map;
