//! Graph to plan.
mod caps;
pub use caps::Caps;
