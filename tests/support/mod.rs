//! Helpers that tests share.

pub mod command;
pub mod docs;
pub mod gpu;
pub mod harness;
pub mod layer;
pub mod numbers;
pub mod player;
pub mod probes;
pub mod sequence;
pub mod sweep;
