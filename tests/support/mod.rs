//! What tests share.

pub mod gpu;
