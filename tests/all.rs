//! Every test of the workspace, in one binary.

/// Naive f64 twins of the operators, and the vectors that prove them.
mod reference;
/// What tests share.
mod support;
