//! Geometry of drawing passes as data: buffers, what is drawn of them, and how it becomes fragments.

use afterimage_base::Shared;
use afterimage_wgsl::{Located, NumberKind};
use serde::Serialize;

use super::resource::BufferId;

/// Draws of a pass with one pipeline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Geometry {
    /// The fragment entry point; without one, only depth is drawn.
    pub fragment: Option<Shared<str>>,
    /// Buffers of vertices and of instances. Locations count on from one to the next.
    pub vertices: Vec<VertexBuffer>,
    /// Numbers of vertices, 32 bits each. Without them, vertices are drawn in order.
    pub indices: Option<BufferId>,
    /// Ranges that are drawn.
    pub draws: Draws,
    /// Rasterization.
    pub raster: Raster,
}

/// Ranges that are drawn, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub enum Draws {
    /// Ranges that are known now.
    Ranges(Vec<DrawRange>),
    /// Ranges that a buffer holds.
    Indirect(IndirectDraws),
}

/// A range of vertices and instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DrawRange {
    /// The first vertex; the first index, if there are indices.
    pub first: u32,
    /// Vertices, or indices, of an instance.
    pub count: u32,
    /// Offset of each index; 0 without indices.
    pub base_vertex: i32,
    /// The first instance.
    pub first_instance: u32,
    /// Instances.
    pub instances: u32,
}

/// Ranges that a buffer of the plan holds, so that an earlier pass chooses what is drawn. Each is four numbers of 32
/// bits: count, instances, first vertex, first instance. With indices it is five: count, instances, first index, base
/// vertex, first instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct IndirectDraws {
    /// The buffer.
    pub buffer: BufferId,
    /// The first byte of the first range, a multiple of 4.
    pub offset: u64,
    /// The number of ranges, without gaps. Those with a count or instances of 0 draw nothing.
    pub ranges: u32,
}

/// A buffer with the arguments of a vertex entry point, without gaps.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct VertexBuffer {
    /// The buffer.
    pub buffer: BufferId,
    /// True if it continues with each instance, and not with each vertex.
    pub per_instance: bool,
    /// The formats of successive locations.
    pub formats: Vec<VertexFormat>,
}

/// The format of a vertex attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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

/// Rasterization state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Raster {
    /// Primitive topology.
    pub topology: Topology,
    /// Culled sides of triangles.
    pub cull: Cull,
    /// True if the vertices of a front side go around clockwise, and not counterclockwise, as they are seen on a screen
    /// with y up.
    pub clockwise: bool,
    /// Constant depth bias, in the smallest steps of the depth's format.
    pub bias: i32,
    /// Slope-scaled depth bias.
    pub slope_bias: f32,
}

/// Primitive topology.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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

/// Culled sides of triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Cull {
    /// Both are drawn.
    #[default]
    None,
    /// The front.
    Front,
    /// The back.
    Back,
}

impl Geometry {
    /// The buffers of vertices, then that of indices and that of ranges.
    pub fn buffers(&self) -> impl Iterator<Item = BufferId> + '_ {
        let ranges = self.indirect().map(|indirect| indirect.buffer);
        self.vertices.iter().map(|vertices| vertices.buffer).chain(self.indices).chain(ranges)
    }

    /// The ranges in a buffer, if that is what it draws.
    pub fn indirect(&self) -> Option<IndirectDraws> {
        match self.draws {
            Draws::Indirect(indirect) => Some(indirect),
            Draws::Ranges(_) => None,
        }
    }

    /// Attributes that the buffers give to a vertex entry point.
    pub fn attributes(&self) -> Vec<Located> {
        let formats = self.vertices.iter().flat_map(|vertices| &vertices.formats);
        formats.zip(0..).map(|(format, location)| format.located(location)).collect()
    }
}

impl DrawRange {
    /// The first vertices, or indices, of the first instances.
    pub const fn new(count: u32, instances: u32) -> Self {
        Self { first: 0, count, base_vertex: 0, first_instance: 0, instances }
    }
}

impl IndirectDraws {
    /// End of the last range in the buffer.
    pub fn end(&self, has_indices: bool) -> u64 {
        let bytes = u64::from(self.ranges) * if has_indices { 20 } else { 16 };
        self.offset.saturating_add(bytes)
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
