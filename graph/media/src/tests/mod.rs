//! Tests of what is not public: cameras and primaries of files, ICC profiles.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod camera;
mod chromaticities;
mod errors;
mod icc;
mod jpeg;
mod orientation;
mod png_colors;
mod profiles;
mod radiance;
mod scans;
mod windows;
