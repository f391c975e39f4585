//! The CPU references: every operator in f64, written as plainly as possible.
//!
//! A CPU reference takes and gives numbers, triples or an [`image::Image`] and knows nothing of graphs or
//! devices. Tests run a node on the GPU and compare it with its CPU reference; [`vectors`] compares the
//! CPU references themselves with printed numbers.

pub(crate) mod math;

pub(crate) mod image;
pub(crate) mod sanitize;

pub(crate) mod color;
pub(crate) mod transfer;

pub(crate) mod exposure;
pub(crate) mod purkinje;
pub(crate) mod stride;

pub(crate) mod gaussian;
pub(crate) mod local;

pub(crate) mod bilateral;
pub(crate) mod bloom;
pub(crate) mod resample;
pub(crate) mod resolve;

pub(crate) mod agx;
pub(crate) mod curves;
pub(crate) mod gamut;
pub(crate) mod gt7;
pub(crate) mod oklab;

pub(crate) mod fog;
pub(crate) mod fxaa;
pub(crate) mod gtao;
pub(crate) mod haze;
pub(crate) mod lens;
pub(crate) mod lens_blur;
pub(crate) mod outline;
pub(crate) mod shadow;
pub(crate) mod sharpen;
pub(crate) mod smaa;
pub(crate) mod ssao;
pub(crate) mod taa;
pub(crate) mod view;
pub(crate) mod warp;

pub(crate) mod film_grain;
pub(crate) mod grade;
pub(crate) mod lut;
pub(crate) mod vignette;
pub(crate) mod volume;

mod vectors;
