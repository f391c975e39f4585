//! Tests of the planner without a device: properties of the plans of random graphs, and faults that `verify` must find.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod bands;
mod blocks;
mod broken;
mod colorimetry;
mod contract;
mod devices;
mod drawing;
mod dynamic;
mod facts;
mod fault_counters;
mod faults;
mod figures;
mod fusion;
mod golden;
mod host_outputs;
mod kernels;
mod limits;
mod machine;
mod messages;
mod model;
mod pipelines;
mod pixels;
mod plan_cache;
mod prices;
mod printing;
mod properties;
mod rectangles;
mod report_cases;
mod skipped;
mod stability;
mod stages;
mod support;
#[expect(dead_code, reason = "tests with a GPU need more of it")]
#[path = "../../../tests/support/sweep.rs"]
mod sweep;
mod switches;
mod wrong_shaders;
