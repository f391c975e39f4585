//! Drawing passes as data: what is drawn into, and what draws.

use super::blend::{Blend, WriteMask};
use super::geometry::Geometry;
use super::resource::{ImageId, Resource};
use serde::Serialize;

/// One mip level of one layer of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Subresource {
    /// The image.
    pub image: ImageId,
    /// The mip level, 0 for the finest.
    pub level: u32,
    /// The layer.
    pub layer: u32,
}

impl From<ImageId> for Subresource {
    fn from(image: ImageId) -> Self {
        Self { image, level: 0, layer: 0 }
    }
}

impl ImageId {
    /// A mip level of the first layer.
    pub fn level(self, level: u32) -> Subresource {
        Subresource { level, ..self.into() }
    }
}

impl Subresource {
    /// The same level of another layer.
    pub fn layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }
}

/// Attachments and content of a drawing pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drawing {
    /// The attachments for color, by the `@location` of a fragment's results.
    pub colors: Vec<ColorAttachment>,
    /// The attachment for depth.
    pub depth: Option<DepthAttachment>,
    /// The draws.
    pub contents: DrawContents,
}

/// Content of an attachment before the first draw of a pass.
///
/// There is no choice to leave it undefined: to clear costs no more, and a frame must not depend on what memory held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Load<T> {
    /// This value.
    Clear(T),
    /// The result of the passes before.
    Keep,
}

/// An attachment for color.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ColorAttachment {
    /// The image.
    pub target: Subresource,
    /// Content before the first draw.
    pub load: Load<[f64; 4]>,
    /// Blending. For passes that a host fills, its pipelines state it.
    pub blend: Blend,
    /// The channels that are written; likewise.
    pub writes: WriteMask,
}

/// An attachment for depth, in the format `Depth16Unorm` or `Depth32Float`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthAttachment {
    /// The image.
    pub target: Subresource,
    /// Test and writes.
    pub test: DepthTest,
}

/// The depth test of a drawing pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthTest {
    /// Content before the first draw.
    pub load: Load<f32>,
    /// Comparison with the stored depth. For passes that a host fills, its pipelines state it.
    pub compare: Compare,
    /// True if fragments that pass the test replace the depth.
    pub write: bool,
}

impl Default for DepthTest {
    /// The nearest fragment, with 0 at the near plane and 1 at the far plane.
    fn default() -> Self {
        Self { load: Load::Clear(1.0), compare: Compare::Less, write: true }
    }
}

impl DepthTest {
    /// The nearest fragment, with 1 at the near plane and 0 at the far plane: a reversed depth.
    pub const REVERSED: Self = Self { load: Load::Clear(0.0), compare: Compare::Greater, write: true };
}

/// Comparison of two depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Compare {
    /// The new one is smaller.
    Less,
    /// The new one is smaller, or they are equal.
    LessEqual,
    /// They are equal.
    Equal,
    /// The new one is larger, or they are equal.
    GreaterEqual,
    /// The new one is larger.
    Greater,
    /// Always.
    Always,
}

/// Content of a drawing pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum DrawContents {
    /// Nothing: the attachments are cleared.
    Nothing,
    /// Geometry, by the vertex entry point that the pass's one kernel names.
    Geometry(Box<Geometry>),
    /// Whatever the host records; the pass has no kernel.
    Host,
}

impl Drawing {
    /// Its attachments: colors, then depth.
    pub fn targets(&self) -> impl Iterator<Item = Subresource> + '_ {
        let colors = self.colors.iter().map(|color| color.target);
        colors.chain(self.depth.map(|depth| depth.target))
    }

    /// The images that it draws into, each once.
    pub fn images(&self) -> Vec<ImageId> {
        let mut images = Vec::new();
        for Subresource { image, .. } in self.targets() {
            if !images.contains(&image) {
                images.push(image);
            }
        }
        images
    }

    /// Its attachments that are not cleared first.
    pub fn kept(&self) -> impl Iterator<Item = Subresource> + '_ {
        let colors = self.colors.iter().filter(|color| color.load == Load::Keep).map(|color| color.target);
        let depth = self.depth.filter(|depth| depth.test.load == Load::Keep);
        colors.chain(depth.map(|depth| depth.target))
    }

    /// The geometry, if the pass has its own.
    pub fn geometry(&self) -> Option<&Geometry> {
        match &self.contents {
            DrawContents::Geometry(geometry) => Some(geometry),
            DrawContents::Nothing | DrawContents::Host => None,
        }
    }

    /// The images that it blends into. What it replaces is not blended.
    pub fn blended(&self) -> impl Iterator<Item = ImageId> + '_ {
        let blended = self.colors.iter().filter(|color| color.blend != Blend::REPLACE);
        blended.map(|color| color.target.image)
    }

    /// The images whose numbers may not be finite after it, because it adds up, or nobody knows what a host draws.
    pub fn unbounded(&self) -> impl Iterator<Item = ImageId> + '_ {
        let is_host = self.contents == DrawContents::Host;
        let unbounded = self.colors.iter().filter(move |color| is_host || !color.blend.stays_finite());
        unbounded.map(|color| color.target.image)
    }

    /// Returns whether the image is its depth.
    pub fn is_depth(&self, image: ImageId) -> bool {
        self.depth.is_some_and(|depth| depth.target.image == image)
    }

    /// Resources that it reads besides the arguments of its kernel.
    pub(super) fn reads(&self) -> impl Iterator<Item = Resource> + '_ {
        let kept = self.kept().map(|kept| Resource::Image(kept.image));
        let buffers = self.geometry().into_iter().flat_map(Geometry::buffers);
        kept.chain(buffers.map(Resource::Buffer))
    }
}
