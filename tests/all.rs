//! Every test of the workspace, in one binary.

/// Each kind on the GPU against its f64 twin.
mod nodes;
/// Naive f64 twins of the operators, and the vectors that prove them.
mod reference;
/// What tests share.
mod support;
