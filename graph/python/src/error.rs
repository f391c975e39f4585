//! Errors as the exceptions of `afterimage._errors`.

use afterimage::Error;
use afterimage::host::PostError;
use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_lab::LabError;
use afterimage_media::{CodecError, FileError};
use afterimage_plan::PlanError;
use pyo3::prelude::*;

/// The error of a call. It becomes an exception once the interpreter is attached again.
pub(crate) enum Failure {
    /// The text of a pipeline, or a change to it.
    Pipeline(Diagnostics),
    /// The pipeline cannot be planned at this size.
    Plan(String),
    /// A name or a value of a parameter.
    Parameter(String),
    /// An image, a camera or a size.
    Image(String),
    /// A file.
    File(String),
    /// The graphics device or its driver.
    Device(String),
}

impl Failure {
    /// The name of the exception, its text, and the diagnostics as JSON.
    fn parts(self) -> (&'static str, String, String) {
        let plain = |name, text| (name, text, "[]".to_owned());
        match self {
            Self::Pipeline(found) => ("PipelineError", found.render(Style::Plain), found.to_json().to_string()),
            Self::Plan(text) => plain("PipelineError", text),
            Self::Parameter(text) => plain("ParameterError", text),
            Self::Image(text) => plain("ImageError", text),
            Self::File(text) => plain("FileError", text),
            Self::Device(text) => plain("DeviceError", text),
        }
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let (name, text, diagnostics) = failure.parts();
        Python::attach(|py| {
            let class = py.import("afterimage._errors").and_then(|module| module.getattr(name));
            match class.and_then(|class| class.call1((text, diagnostics))) {
                Ok(exception) => Self::from_value(exception),
                Err(error) => error,
            }
        })
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Wrong(diagnostics) => diagnostics.into(),
            Error::Unreadable(text) => Self::File(text),
            Error::Name(text) => Self::Parameter(text),
            Error::Image(text) => Self::Image(text),
            Error::Post(error) => error.into(),
            Error::Gpu(error) => error.into(),
            other => Self::Plan(other.to_string()),
        }
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Pipeline(diagnostics)
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::Plan(error.to_string())
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::TooLarge { .. }
            | GpuError::MissingInput(_)
            | GpuError::MissingDraw(_)
            | GpuError::MissingBlock { .. }
            | GpuError::WrongBlock { .. }
            | GpuError::WrongImage { .. }
            | GpuError::UnfitImage { .. } => Self::Image(error.to_string()),
            GpuError::Shader(_) => Self::Plan(error.to_string()),
            _ => Self::Device(error.to_string()),
        }
    }
}

impl From<PostError> for Failure {
    fn from(error: PostError) -> Self {
        match error {
            PostError::Plan(error) => error.into(),
            PostError::Gpu(error) => error.into(),
            PostError::MissingInput { .. } => Self::Image(error.to_string()),
            PostError::UnknownParameter(_)
            | PostError::WrongType { .. }
            | PostError::Refused { .. }
            | PostError::UnknownHandle(_)
            | PostError::NoTier
            | PostError::TooManyFrames { .. } => Self::Parameter(error.to_string()),
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::File(error.to_string())
    }
}

impl From<CodecError> for Failure {
    fn from(error: CodecError) -> Self {
        Self::Image(with_hint(error.message.clone(), error.hint.as_deref()))
    }
}

impl From<LabError> for Failure {
    fn from(error: LabError) -> Self {
        match error {
            LabError::Request { message, hint } => Self::Image(with_hint(message, hint.as_deref())),
            LabError::Machine(message) => Self::Device(message),
            LabError::File(error) => error.into(),
            LabError::Pipeline(diagnostics) => diagnostics.into(),
            LabError::Post(error) => error.into(),
        }
    }
}

fn with_hint(message: String, hint: Option<&str>) -> String {
    hint.map_or(message.clone(), |hint| format!("{message}\n  hint: {hint}"))
}
