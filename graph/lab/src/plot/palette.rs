//! Colors of charts on white.

pub const INK: &str = "#1c2128";
/// Text next to the axes.
pub const SOFT: &str = "#6b7480";
pub const GRID: &str = "#e3e6ea";
pub const BLUE: &str = "#3563c9";
pub const ORANGE: &str = "#c9621b";
pub const GREEN: &str = "#2f6f4f";
