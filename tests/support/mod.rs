//! What tests share.

pub mod gpu;
pub mod layer;
pub mod numbers;
pub mod player;
