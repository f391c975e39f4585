//! Reports of a finished plan: text, JSON, SVG, hash and difference.

mod colorimetry;
mod diff;
mod hash;
mod json;
mod names;
mod svg;
mod text;
mod units;

pub use diff::{PlanDiff, diff};
pub use hash::PlanHash;
