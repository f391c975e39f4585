//! Options of reading.

use crate::codec::{Budget, ColorSpace};

/// Options of reading a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadOptions {
    /// The memory that decoding may take.
    pub budget: Budget,
    /// The color space of a color picture, whatever the file states; `None` believes the file.
    pub space: Option<ColorSpace>,
    /// True if the color of a PNG is multiplied by its alpha, as that of an EXR is. Otherwise alpha is a number of its
    /// own, such as a mask.
    pub premultiplied: bool,
    /// True if the picture of an EXR file is its data window, which may be larger than the display window (overscan) or
    /// a part of it. Otherwise it is the display window, with zeros where the file has no pixels.
    pub data_window: bool,
    /// The first row that is read of the picture of an EXR file, and how many: only the blocks that show them are
    /// decoded. Other formats are read whole, and so is an EXR file without it.
    pub rows: Option<[u32; 2]>,
}

impl From<Budget> for ReadOptions {
    fn from(budget: Budget) -> Self {
        Self { budget, space: None, premultiplied: true, data_window: false, rows: None }
    }
}
