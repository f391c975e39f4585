//! Rectangles of texels.

use afterimage_graph::image::Size;

use crate::full_screen::color_pass;

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

/// Begins a pass that draws all of a view, or a rectangle of it around which everything stays.
#[doc(hidden)] // For the crate `afterimage`.
pub fn color_pass_in<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: Option<&str>,
    view: &wgpu::TextureView,
    rectangle: Option<Rectangle>,
) -> wgpu::RenderPass<'e> {
    let load = rectangle.map_or(wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), |_| wgpu::LoadOp::Load);
    let mut pass = color_pass(encoder, label, view, load);
    if let Some(Rectangle { x, y, width, height }) = rectangle {
        pass.set_scissor_rect(x, y, width, height);
    }
    pass
}

impl std::fmt::Display for Rectangle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{} from {},{}", self.width, self.height, self.x, self.y)
    }
}
