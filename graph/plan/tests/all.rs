//! Tests of the planner without a device: properties of the plans of random graphs, and faults that `verify` must find.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod blocks;
mod broken;
mod colorimetry;
mod contract;
mod devices;
mod drawing;
mod dynamic;
mod facts;
mod faults;
mod figures;
mod fusion;
mod golden;
mod kernels;
mod limits;
mod machine;
mod model;
mod odd;
mod pipelines;
mod pixels;
mod plan_cache;
mod planned;
mod prices;
mod printing;
mod probes;
mod properties;
mod rectangles;
mod shown;
mod skipped;
mod stability;
mod stages;
#[expect(dead_code, reason = "tests with a GPU need more of it")]
#[path = "../../../tests/support/sweep.rs"]
mod sweep;
mod switches;
mod told;
mod wrong_shaders;
