//! Reports of a finished plan: text, JSON, SVG, hash and difference.

mod colorimetry;
mod content;
mod diff;
mod drawings;
mod fnv;
mod hash;
mod json;
mod kernels;
mod names;
mod svg;
mod text;
mod units;

pub use diff::{PlanDiff, diff};
pub use hash::PlanHash;
