//! Tests of the viewer, with a device and without a window.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod comparisons;
mod files;
mod gestures;
mod grading;
mod inputs;
mod model;
mod screen;
mod statements;
mod support;
mod text;
mod unsaved;
mod upkeep;
mod window;
