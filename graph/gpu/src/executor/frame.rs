//! The inputs of a host for one frame.

use afterimage_graph::image::Size;
use afterimage_graph::node::BlockData;
use wgpu::{Texture, TextureDimension, TextureFormat, TextureView};

use super::rectangle::Rectangle;

/// One frame's inputs, outputs and time.
#[derive(Clone, Copy, Default)]
pub struct Frame<'a> {
    /// The host's images, by the names of the pipeline's inputs; names that the plan does not need are ignored. Their
    /// textures have the usage `TEXTURE_BINDING`, and for colors best the format `Rgba16Float`. The size of the first
    /// one is that of the frame: another one needs no call, but a plan.
    pub inputs: &'a [(&'a str, &'a TextureView)],
    /// The host's blocks, such as its camera, by the names of the pipeline's inputs; likewise.
    pub blocks: &'a [(&'a str, &'a BlockData)],
    /// The host's images for outputs, by their names; the executor keeps a texture for each output that is not named.
    /// They have the size of the frame, the usage `RENDER_ATTACHMENT`, and any format that can be drawn to. A view has
    /// one level and one layer, and its texture is none of the inputs: a pass may read those while it writes.
    pub outputs: &'a [(&'a str, &'a TextureView)],
    /// The formats of views that have another one than their texture, by the names of inputs and outputs. Without it an
    /// output's view is tried, once for each kind of texture.
    pub formats: &'a [(&'a str, TextureFormat)],
    /// The mip levels that views begin with, by the names of inputs and outputs: for views of textures with several
    /// levels. Without it a view that can be drawn to is tried once, and any other one is an error.
    pub levels: &'a [(&'a str, u32)],
    /// The rectangles of images, by the names of inputs and outputs; an image without one is whole. New rectangles of
    /// equal size need no new plan. What is around the rectangle of an output stays as it is.
    pub rectangles: &'a [(&'a str, Rectangle)],
    /// Factors of the colors of inputs, such as the exposure of the view, by their names: at least 0. They are applied
    /// before colors are limited to the range of half floats, and need no plan after the first.
    pub factors: &'a [(&'a str, f32)],
    /// Seconds since the start. Shaders see it as evenly after days as in the first second.
    pub time: f64,
    /// Seconds since the frame before. With 0, exposure and the like do not adapt.
    pub dt: f32,
    /// Its relation to the frame before.
    pub kind: FrameKind,
}

/// The relation of a frame to the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameKind {
    /// It is the next one, after `dt`.
    #[default]
    Next,
    /// It does not, as after a cut, a teleport or a load: histories and adaptation begin in it.
    Cut,
    /// It is the last frame with other values of parameters: the host's images are unchanged, and so is the number of
    /// the frame. A plan that is [`repeatable`](afterimage_plan::Options::repeatable) and has rendered it takes time
    /// and state from that frame, and runs only the passes that depend on the values. Any other plan runs all passes;
    /// it resets if the frame was a cut, and otherwise no time passes.
    Redraw,
}

impl FrameKind {
    /// A cut, or else the next frame.
    pub fn cut_if(is_cut: bool) -> Self {
        if is_cut { Self::Cut } else { Self::Next }
    }
}

impl Frame<'_> {
    /// The rectangle of an image.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn rectangle(&self, port: &str) -> Option<Rectangle> {
        self.rectangles.iter().find(|(name, _)| *name == port).map(|(_, rectangle)| *rectangle)
    }

    /// The inputs and outputs of whose images it states more than a view.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn described_ports(&self) -> impl Iterator<Item = &str> {
        let rectangles = self.rectangles.iter().map(|(name, _)| *name);
        rectangles.chain(self.formats.iter().map(|(name, _)| *name)).chain(self.levels.iter().map(|(name, _)| *name))
    }

    /// The mip level that a view begins with, as far as it is stated.
    pub(crate) fn stated_level(&self, port: &str) -> Option<u32> {
        self.levels.iter().find(|(name, _)| *name == port).map(|(_, level)| *level)
    }

    /// The texels that a view shows. Levels are known by now.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn size_of(&self, port: &str, view: &TextureView) -> Size {
        size_of_level(view.texture(), self.stated_level(port).unwrap_or(0))
    }

    /// The format of a view of the host, as far as it is stated.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn stated_format(&self, port: &str) -> Option<TextureFormat> {
        self.formats.iter().find(|(name, _)| *name == port).map(|(_, format)| *format)
    }
}

impl<'a> Frame<'a> {
    /// The views of inputs and outputs by their names.
    pub(crate) fn views(&self) -> impl Iterator<Item = (&'a str, &'a TextureView)> {
        self.inputs.iter().chain(self.outputs).copied()
    }
}

/// The view of that name.
pub fn view_of<'a>(views: &[(&str, &'a TextureView)], name: &str) -> Option<&'a TextureView> {
    views.iter().find(|(known, _)| *known == name).map(|(_, view)| *view)
}

/// The texels of a mip level of a texture.
pub(crate) fn size_of_level(texture: &Texture, level: u32) -> Size {
    let extent = texture.size().mip_level_size(level, texture.dimension());
    let depth = if texture.dimension() == TextureDimension::D3 { extent.depth_or_array_layers } else { 1 };
    Size::volume(extent.width, extent.height, depth)
}
