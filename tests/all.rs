//! Every test of the workspace, in one binary.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary has no outside")]

/// The figures of `afterimage bench`.
mod bench;
/// The program as a user runs it.
mod cli;
/// The one clock of `measure` and `bench`.
mod clock;
/// The executor as a host meets it.
mod executor;
/// A few seconds of what `fuzz` runs for hours.
mod fuzzing;
/// Time against error, and the search for the best of both.
mod measure;
/// The figures that `measure` gives, against published ones.
mod metrics;
/// Each kind on the GPU against its f64 twin.
mod nodes;
/// Every shipped pipeline: checked, planned, proved, rendered under the validation layer.
mod pipelines;
/// Naive f64 twins of the operators, and the vectors that prove them.
mod reference;
/// Faults that `stress` must find, and what must have none.
mod stress;
/// What tests share.
mod support;
/// A node kind from another crate.
mod third_party;
/// Chains in workgroup memory against the same passes one by one.
mod tiles;
/// The richest pipeline as a whole.
mod tsushima;
