//! Limits of a pipeline.
//!
//! With them the worst known pipelines are planned in less than two seconds and 500 MB. `graph/docs/limits.md`
//! lists them with figures.

/// Nodes; pipelines used as nodes and what is in them count.
pub const MAX_NODES: usize = 1 << 14;
/// Inputs of a pipeline.
pub const MAX_INPUTS: usize = 256;
/// Outputs of a pipeline.
pub const MAX_OUTPUTS: usize = 256;
/// Tiers of a pipeline.
pub const MAX_TIERS: usize = 64;
/// Facts that a pipeline lists.
pub const MAX_FACTS: usize = 256;
/// Parameters that a pipeline lists as usual.
pub const MAX_USUAL: usize = 256;
/// Bytes of a label, and of a name with those of the pipelines around it.
pub const MAX_NAME: usize = 256;
/// Bytes of a node's condition, joined with those of the pipelines around it.
pub const MAX_CONDITION: usize = 2048;
/// Bytes of the pipeline files that a pipeline names, each as often as it is used.
pub const MAX_TEXT: usize = 8 << 20;
/// Bytes of the files that parameters name, each as often as it is named.
pub const MAX_FILE_BYTES: usize = 64 << 20;
/// Frames that a wire can reach back.
pub const MAX_PREVIOUS: u32 = 16;
/// Frames in one of which a node can run.
pub const MAX_EVERY: u32 = 16;
/// Pipelines within pipelines, and files that extend files.
pub const MAX_DEPTH: usize = 16;
