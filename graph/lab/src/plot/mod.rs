//! Axes, labels and colors of charts.

pub mod axis;
pub mod labels;
pub mod palette;

pub use afterimage_base::svg;
