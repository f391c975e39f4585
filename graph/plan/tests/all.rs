//! Tests of the planner without a device: properties of the plans of random graphs, and faults that `verify` must find.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod colorimetry;
mod contract;
mod dynamic;
mod faults;
mod fusion;
mod golden;
mod limits;
mod pipelines;
mod plan_cache;
mod planned;
mod printing;
mod properties;
mod skipped;
mod stability;
mod stages;
mod switches;
