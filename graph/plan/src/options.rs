//! The switches of the planner.

use afterimage_graph::node::Bake;
use serde::Serialize;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Options {
    /// Joins passes: functions of a pixel, warps, and halvings by rows where they pay.
    pub fuse: bool,
    /// Selects the halvings that run row by row.
    pub row_downsample: When,
    /// Memory sharing of transient images.
    pub alias: Alias,
    /// Allows the last frame to be repeated in part with other values: images share no memory, and the state
    /// before each frame is kept.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub repeatable: bool,
    /// Puts each pass in a batch of its own.
    pub serial: bool,
    /// Stores every intermediate in 32 bits and filters with all of them, where a device's own filter has
    /// eight bits of fraction: the reference of `measure`.
    pub exact: bool,
    /// Prefers the order with the fewest batches to that with the smallest memory.
    pub batches_first: bool,
    /// Runs unchecked shaders, too, with the driver's checks of indices and loops. Pixels are the same.
    pub bounds_checks: bool,
    /// Replaces `bake` of all nodes but those that have `Off`. Exact plans have no tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bake: Option<Bake>,
    /// Computes nodes with `bake: Auto` for every pixel: for a plan that renders a single frame, where filling a table
    /// takes longer than it saves.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub one_frame: bool,
    /// Runs each untrusted function once more, to count the pixels where it returns numbers that are not finite or
    /// has loops that are ended: see [`Plan::fault_counters`](crate::Plan::fault_counters). Compares tables with their
    /// nodes.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub count_faults: bool,
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
            one_frame: false,
            count_faults: false,
        }
    }
}

/// Conditions for an optional form of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum When {
    Never,
    /// On devices with fast workgroup memory, if it is expected to be faster.
    WhereItPays,
    /// Wherever it is possible: for tests and measurements.
    Always,
}

/// Memory sharing of transient images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Alias {
    /// Each image has its own.
    None,
    /// Images with equal descriptions share a pooled texture.
    Pool,
    /// All images lie in one heap, at offsets; where the backend cannot, the pool.
    Placed,
}
