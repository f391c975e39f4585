//! Every test of the workspace, in one binary.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary has no outside")]

/// The program as a user runs it.
mod cli;
/// Each kind on the GPU against its f64 twin.
mod nodes;
/// Naive f64 twins of the operators, and the vectors that prove them.
mod reference;
/// What tests share.
mod support;
/// Chains in workgroup memory against the same passes one by one.
mod tiles;
