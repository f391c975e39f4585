//! Measurements of pipelines: their cost, their accuracy, and their results for extreme inputs.
//!
//! - [`measure`]: time against error, for each tier and each quality switch of a pipeline.
//! - [`tune`]: the quality switches with the smallest error in a time, or the shortest time within an error.
//! - [`mod@bench`]: the time of a frame and of its passes, compared with the bandwidth of the device.
//! - [`lut`]: the color nodes of a pipeline as a table for other programs, with its error.
//! - [`stress`]: every pipeline and every node kind with extreme images, parameters and sizes.
//! - [`metrics`], [`plot`]: image metrics and SVG charts.
//!
//! Options come in as plain structs, and results go out as reports. Pipelines and node kinds are given as graphs and
//! registries: this crate parses no command line. It has no table of node kinds: what the results of a kind keep is
//! declared by [`Node::invariants`](afterimage_graph::node::Node::invariants). Two kinds are named: `DemoScene`, which
//! [`scene`] renders, and `Dither`, which [`measure`] switches off before outputs.

#![allow(
    missing_docs,
    reason = "no host and no author of nodes builds on this crate; names that say it all have no comment"
)]

pub mod bench;
mod error;
mod files;
mod frame_time;
pub mod lut;
pub mod measure;
pub mod metrics;
pub mod plot;
mod progress;
pub mod scene;
mod shell;
pub mod stress;
pub mod tune;

pub use error::LabError;
pub use progress::Progress;
pub use shell::shell_word;
