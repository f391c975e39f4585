//! Drawing passes as data: what is drawn into, with which geometry, and how it becomes pixels.

use afterimage_base::Shared;
use afterimage_wgsl::{Located, NumberKind};

use super::resource::{BufferId, ImageId, Resource};

/// One mip level of one layer of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
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

/// What a drawing pass draws into, and what it draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The attachments for color, by the `@location` of a fragment's results.
    pub colors: Vec<ColorAttachment>,
    /// The attachment for depth.
    pub depth: Option<DepthAttachment>,
    /// What is drawn.
    pub contents: DrawContents,
}

/// What an attachment holds before the first draw of a pass.
///
/// There is no choice to leave it undefined: to clear costs no more, and a frame must not depend on what memory held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<T> {
    /// This value.
    Clear(T),
    /// What the passes before have drawn.
    Keep,
}

/// An attachment for color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorAttachment {
    /// What is drawn into.
    pub target: Subresource,
    /// What it holds at first.
    pub load: Load<[f64; 4]>,
}

/// An attachment for depth, in the format `Depth16Unorm` or `Depth32Float`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthAttachment {
    /// What is drawn into.
    pub target: Subresource,
    /// Test and writes.
    pub test: DepthTest,
}

/// The depth test of a drawing pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthTest {
    /// What the attachment holds at first.
    pub load: Load<f32>,
    /// How a fragment's depth must compare to the one that is there. For passes that a host fills, its pipelines say.
    pub compare: Compare,
    /// Whether fragments that pass the test replace the depth.
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

/// How two depths compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// What a drawing pass draws.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawContents {
    /// Nothing: the attachments are cleared.
    Nothing,
    /// Geometry, by the vertex entry point that the pass's one kernel names.
    Geometry(Box<Geometry>),
    /// Whatever the host records; the pass has no kernel.
    Host,
}

/// One draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// The fragment entry point; without one, only depth is drawn.
    pub fragment: Option<Shared<str>>,
    /// Buffers of vertices and of instances. Locations count on from one to the next.
    pub vertices: Vec<VertexBuffer>,
    /// Numbers of vertices, 32 bits each. Without them, vertices are drawn in order.
    pub indices: Option<BufferId>,
    /// Vertices, or indices, of an instance.
    pub count: u32,
    /// Instances.
    pub instances: u32,
    /// How triangles become fragments.
    pub raster: Raster,
}

/// A buffer with the arguments of a vertex entry point, without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexBuffer {
    /// The buffer.
    pub buffer: BufferId,
    /// Whether it goes on with each instance, and not with each vertex.
    pub per_instance: bool,
    /// The formats of successive locations.
    pub formats: Vec<VertexFormat>,
}

/// The format of a vertex attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexFormat {
    /// `f32`.
    Float32,
    /// `vec2f`.
    Float32x2,
    /// `vec3f`.
    Float32x3,
    /// `vec4f`.
    Float32x4,
    /// `u32`.
    Uint32,
    /// `vec4f` of four bytes, 0 to 1.
    Unorm8x4,
}

/// How geometry becomes fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Raster {
    /// What vertices make up.
    pub topology: Topology,
    /// Which sides of triangles are not drawn.
    pub cull: Cull,
    /// Whether the vertices of a front side go around clockwise, and not counterclockwise, as they are seen on a
    /// screen with y up.
    pub clockwise: bool,
    /// What is added to depths, in the smallest steps of the depth's format.
    pub bias: i32,
    /// What is added to depths for each unit of their slope.
    pub slope_bias: f32,
}

/// What vertices make up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// A triangle of each three.
    #[default]
    Triangles,
    /// A triangle of each vertex and the two before it.
    TriangleStrip,
    /// A line of each two.
    Lines,
    /// A point of each one.
    Points,
}

/// Which sides of triangles are not drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cull {
    /// Both are drawn.
    #[default]
    None,
    /// The front.
    Front,
    /// The back.
    Back,
}

impl Drawing {
    /// What it draws into: colors, then depth.
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

    /// What it draws into without clearing it first.
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

    /// Whether the image is its depth.
    pub fn is_depth(&self, image: ImageId) -> bool {
        self.depth.is_some_and(|depth| depth.target.image == image)
    }

    /// What it reads besides the arguments of its kernel.
    pub(super) fn reads(&self) -> impl Iterator<Item = Resource> + '_ {
        let kept = self.kept().map(|kept| Resource::Image(kept.image));
        let buffers = self.geometry().into_iter().flat_map(Geometry::buffers);
        kept.chain(buffers.map(Resource::Buffer))
    }
}

impl Geometry {
    /// The buffers of vertices, then that of indices.
    pub fn buffers(&self) -> impl Iterator<Item = BufferId> + '_ {
        self.vertices.iter().map(|vertices| vertices.buffer).chain(self.indices)
    }

    /// What the buffers give to a vertex entry point.
    pub fn attributes(&self) -> Vec<Located> {
        let formats = self.vertices.iter().flat_map(|vertices| &vertices.formats);
        formats.zip(0..).map(|(format, location)| format.located(location)).collect()
    }
}

impl VertexBuffer {
    /// Bytes from one vertex or instance to the next.
    pub fn stride(&self) -> u64 {
        self.formats.iter().map(|format| format.bytes()).sum()
    }
}

impl VertexFormat {
    /// Bytes of one attribute.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Float32 | Self::Uint32 | Self::Unorm8x4 => 4,
            Self::Float32x2 => 8,
            Self::Float32x3 => 12,
            Self::Float32x4 => 16,
        }
    }

    /// The argument that takes it.
    fn located(self, location: u32) -> Located {
        let (number, width) = match self {
            Self::Float32 => (NumberKind::Float, 1),
            Self::Float32x2 => (NumberKind::Float, 2),
            Self::Float32x3 => (NumberKind::Float, 3),
            Self::Float32x4 | Self::Unorm8x4 => (NumberKind::Float, 4),
            Self::Uint32 => (NumberKind::Uint, 1),
        };
        Located { location, number, width }
    }
}
