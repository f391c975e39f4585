//! The switches of the planner.

use afterimage_graph::node::Bake;
use serde::Serialize;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Options {
    /// Whether passes of point functions and warps are fused.
    pub fuse: bool,
    /// When images are halved row by row.
    pub row_downsample: When,
    /// How transient images share memory.
    pub alias: Alias,
    /// Whether the last frame can be repeated in part with other values: then images share no memory, and the state
    /// before each frame is kept.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub repeatable: bool,
    /// Whether each pass is a batch of its own.
    pub serial: bool,
    /// Whether every intermediate is stored in 32 bits and filtered with all of them, where a device's own filter has
    /// eight bits of fraction: the reference of `measure`.
    pub exact: bool,
    /// Whether the order with the fewest batches is chosen before that with the smallest memory.
    pub batches_first: bool,
    /// Whether unchecked shaders, too, run with the driver's checks of indices and loops. Pixels are the same.
    pub bounds_checks: bool,
    /// Replaces `bake` of all nodes but those that have `Off`. Exact plans have no tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bake: Option<Bake>,
    /// Whether each function that is not trusted runs once more, to count where it makes numbers that are not finite or
    /// has loops that are ended: see [`Plan::probes`](crate::Plan::probes); and whether tables are compared with their
    /// nodes: see [`Baked::error`](crate::Baked::error).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub probes: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            fuse: true,
            row_downsample: When::WhereItPays,
            alias: Alias::Placed,
            repeatable: false,
            serial: false,
            exact: false,
            batches_first: false,
            bounds_checks: false,
            bake: None,
            probes: false,
        }
    }
}

/// When a way to run kernels together is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum When {
    Never,
    /// Where it is expected to be faster, on a device with fast workgroup memory.
    WhereItPays,
    /// Wherever it is possible: for tests and measurements.
    Always,
}

/// How transient images share memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Alias {
    /// Each image has its own.
    None,
    /// Images with equal descriptions share a pooled texture.
    Pool,
    /// All images lie in one heap, at offsets; where the backend cannot, the pool.
    Placed,
}
