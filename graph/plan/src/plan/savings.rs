//! Work of the nodes that no frame does, or not each one.

use afterimage_graph::node::{Resource, VirtualImage};
use serde::Serialize;

use super::pass::Refresh;

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

/// The results of a node that does not run in every frame. They are kept in between.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CachedResults {
    pub node: String,
    pub refresh: Refresh,
    /// The images and buffers. Empty if the node runs in every frame, because it keeps a state that changes.
    pub results: Vec<Resource>,
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

impl Fused {
    /// The image between two passes that are one now.
    pub(crate) fn new(image: &VirtualImage, nodes: &[String]) -> Self {
        Self { image: image.label.clone(), nodes: nodes.to_vec(), bytes_saved: 2 * image.desc.bytes() }
    }
}

/// A run of nodes that became a baked LUT.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Baked {
    pub nodes: Vec<String>,
    /// The size that was asked for: levels of the largest channel.
    pub size: u32,
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
