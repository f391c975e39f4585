//! What tests share.

pub mod gpu;
pub mod layer;
pub mod player;
