//! Limits of a plan. With those of the check (`afterimage_graph::check::limits`) they bound the time and the memory of
//! planning; `graph/docs/limits.md` lists them with figures.

/// Passes that the nodes of a pipeline record.
pub const MAX_PASSES: usize = 1 << 14;
/// Operations that a pass is compiled from, at most, after other passes have become part of it; a pass of one node may
/// have more. Compilers inline all calls, and their time grows with the square of the operations: llvmpipe takes 0.2 s
/// for one `HueCurves`, 7 s for 12 in a pass and 26 s for 24.
pub const MAX_PASS_OPERATIONS: usize = 80_000;
/// Operations that all different passes of a plan are compiled from.
pub const MAX_OPERATIONS: usize = 1 << 23;
pub const MAX_COMPUTED: usize = 8;
/// Bytes of the tables that nodes compute.
pub const MAX_COMPUTED_BYTES: u64 = 8 << 20;
/// Bytes of all tables, those from files included.
pub const MAX_TABLE_BYTES: u64 = 128 << 20;
