//! Rectangles of texels.

use afterimage_graph::image::Size;

/// A rectangle of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// The first column.
    pub x: u32,
    /// The first row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rectangle {
    /// All of an image.
    pub fn whole(size: Size) -> Self {
        Self { x: 0, y: 0, width: size.width, height: size.height }
    }

    /// Columns and rows.
    pub fn size(self) -> Size {
        Size::new(self.width, self.height)
    }

    #[doc(hidden)] // For the crate `afterimage`.
    pub fn lies_in(self, size: Size) -> bool {
        let ends =
            |first: u32, length: u32, all: u32| length > 0 && first.checked_add(length).is_some_and(|end| end <= all);
        ends(self.x, self.width, size.width) && ends(self.y, self.height, size.height)
    }
}

impl std::fmt::Display for Rectangle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{} from {},{}", self.width, self.height, self.x, self.y)
    }
}
