//! Tests of the parsers of color files and of the processes that they contain.
#![allow(missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod clf;
mod color_files;
mod lut;
mod pipeline_files;
