//! Work of the nodes that no frame does, or not each one.

use serde::Serialize;

use super::CachedResults;

/// The work of the nodes that frames do not do: the results of the stages that avoid it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Savings {
    /// Nodes that are not in the plan, and why.
    pub skipped: Vec<Skipped>,
    /// Images that fusion has removed.
    pub fused: Vec<Fused>,
    /// Images that several kernels read together in one pass.
    pub shared_reads: Vec<SharedRead>,
    /// Runs of nodes that became baked LUTs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub baked: Vec<Baked>,
    /// The results of nodes that do not run in every frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cached: Vec<CachedResults>,
}

/// A node that is not in the plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    pub node: String,
    pub why: String,
}

/// An image that fusion has removed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fused {
    /// The image, as `node.port`.
    pub image: String,
    /// The nodes of the pass that now holds both ends.
    pub nodes: Vec<String>,
    /// Bytes that are neither written nor read any more, in one frame.
    pub bytes_saved: u64,
}

/// A run of nodes that became a baked LUT.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Baked {
    pub nodes: Vec<String>,
    /// The size that was asked for: levels of light.
    pub size: u32,
    /// Bytes of the table.
    pub bytes: u64,
    /// True if every frame fills it, because a node reads a value that passes compute.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_every_frame: bool,
    /// In a plan that [counts faults](crate::Options::count_faults), an output of 1024 pixels a row: red is the largest
    /// difference of the table from its nodes, for a random color in each pixel. The last 64 rows are a ramp of grays,
    /// of which green is that of the nodes and blue that of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// An image that several kernels read together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SharedRead {
    /// The image, as `node.port`.
    pub image: String,
    /// The nodes of the pass that reads it.
    pub nodes: Vec<String>,
    /// Bytes that are not read again, in one frame.
    pub bytes_saved: u64,
}
