//! Color math of the built-in nodes in double precision, and the parsers of color files.
//!
//! * Files: [`lut_file`] recognizes a file by its content; [`lut`] has tables, color corrections and their parsers;
//!   [`parse_clf`] reads the Common LUT Format.
//! * [`process`]: color operations in a row, evaluated on the CPU or written as WGSL.
//! * Tone mapping: [`aces2`] is the output transform of ACES 2.0, [`curve_constants`] has the constants of the other
//!   curves, [`oklab`] compares hues and fits colors into a gamut.
//! * [`adaptation`]: white balance.
#![allow(missing_docs, reason = "structs of coefficients, whose fields have the names of the published formulas")]

pub mod aces2;
pub mod adaptation;
pub mod bisection;
mod clf;
pub mod curve_constants;
pub mod display_range;
pub mod lut;
pub mod lut_decoded;
pub mod lut_file;
pub mod oklab;
pub mod process;
pub mod shaper;

pub use clf::parse_clf;
