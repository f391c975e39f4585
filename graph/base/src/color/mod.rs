//! Colorimetry: what the numbers of an image mean as light. Plain data, and the matrices that follow from it.
//!
//! [`Chromaticities`] are the primaries and the white, [`Transfer`] is the transfer function, and [`Colorimetry`] holds
//! both with the luminances that they refer to. All numbers are [`Decimal`]s, so that colorimetry can be compared and
//! hashed as a part of a plan. Matrices are in f64.

mod chromaticities;
mod colorimetry;
mod cones;
mod decimal;
mod luminance;
mod transfer;

pub use chromaticities::{Chromaticities, Xy};
pub use colorimetry::{Colorimetry, GRAPHICS_WHITE};
pub use cones::Cones;
pub use decimal::Decimal;
pub use luminance::{LUMINANCE_REC709, LUMINANCE_REC2020, rec709_luminance};
pub use transfer::{Transfer, hlg_gamma};
