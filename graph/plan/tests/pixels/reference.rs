//! The references of the nodes in f64, as `tests/reference` has them.
#![allow(dead_code, reason = "plans need a part of them")]

#[path = "../../../../tests/reference/color.rs"]
pub(crate) mod color;
#[path = "../../../../tests/reference/image.rs"]
pub(crate) mod image;
#[path = "../../../../tests/reference/math.rs"]
pub(crate) mod math;
#[path = "../../../../tests/reference/sanitize.rs"]
pub(crate) mod sanitize;
