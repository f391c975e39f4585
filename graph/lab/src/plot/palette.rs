//! Colors of charts on white.

/// Titles and names.
pub const INK: &str = "#1c2128";
/// Text next to the axes.
pub const SOFT: &str = "#6b7480";
/// Lines of the grid.
pub const GRID: &str = "#e3e6ea";
/// Data.
pub const BLUE: &str = "#3563c9";
/// Data.
pub const ORANGE: &str = "#c9621b";
/// Data.
pub const GREEN: &str = "#2f6f4f";
