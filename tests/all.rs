//! The tests that need a GPU, several crates, or the program. Pure tests live in their crates.
//!
//! All of them: `cargo test -p afterimage-tests`. One group: `cargo test -p afterimage-tests nodes::`. One test:
//! `cargo test -p afterimage-tests nodes::table::every_kind_with_a_cpu_reference_equals_it`.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

/// Tables in the place of nodes.
mod bake;
/// The figures of `afterimage bench`.
mod bench;
/// Host blocks: cameras.
mod blocks;
/// The program, run as a user runs it.
mod cli;
/// The clock that `measure` and `bench` share.
mod clock;
/// Drawing passes, compared with triangles on the CPU.
mod drawing;
/// Memory and descriptors over many rounds of all work.
mod endurance;
/// The executor, used as a host uses it.
mod executor;
/// Calls of the driver that fail.
mod faults;
/// Nodes that do not run in every frame, and values that are read a frame later.
mod frames;
/// The first inputs of each fuzz target.
mod fuzzing;
/// Kinds with clashing names in one module.
mod isolation;
/// Laws of pictures that all built-in pipelines keep.
mod laws;
/// Devices that are lost.
mod lost;
/// The figures of `measure` and `tune`.
mod measure;
/// Image metrics, compared with published figures.
mod metrics;
/// Kinds without Rust that have several passes, compared with CPU references.
mod node_folders;
/// Each kind on the GPU, compared with its CPU reference.
mod nodes;
/// Every built-in pipeline, rendered under the validation layer.
mod pipelines;
/// A node kind from another crate.
mod plug_in;
/// A pipeline as a host keeps it.
mod post;
/// CPU references of the operators, and the vectors that verify them.
mod reference;
/// Halvings by rows, compared with halvings texel by texel.
mod rows;
/// The table of source systems in the documentation.
mod sources;
/// Faults that `stress` must find, and subjects without any.
mod stress;
/// Shared by tests: the device, the harness of node tests, the program.
mod support;
/// The longest pipeline as a whole.
mod tsushima;
/// Operations whose results a device may choose.
mod undefined;
/// Kinds without Rust whose functions share memory of a workgroup.
mod workgroups;
