//! The native half of the Python package `afterimage`: pipelines, frames, files. The other half, in
//! `python/afterimage`, checks arrays and keeps the time and the cameras of a sequence.

mod error;
mod files;
mod frame;
mod measure;
mod pipeline;
mod plan;
mod value;

/// The module `afterimage._native`.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use super::files::{read, write_exr, write_png};
    #[pymodule_export]
    use super::frame::Color;
    #[pymodule_export]
    use super::pipeline::{Pipeline, built_in};
    #[pymodule_export]
    use super::plan::PlanView;
}
