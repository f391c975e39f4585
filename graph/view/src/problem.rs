//! Errors of the viewer.

use afterimage::host::PostError;
use afterimage_gpu::GpuError;
use afterimage_graph::check::GraphInput;
use afterimage_graph::diagnostic::Diagnostics;

/// An error that the viewer shows.
#[derive(Clone, Debug)]
pub enum Problem {
    /// Errors in a pipeline, or in a file that it names.
    Pipeline(Diagnostics),
    /// Anything else: lower case, no full stop.
    Message {
        message: String,
        /// Advice for the user, if there is any.
        hint: Option<String>,
    },
    /// The device is gone: everything on it must be made again.
    DeviceLost,
}

impl Problem {
    /// A problem without a location.
    pub fn message(message: impl Into<String>) -> Self {
        Self::Message { message: message.into(), hint: None }
    }

    /// The same with what the user can do.
    pub fn hint(self, text: impl Into<String>) -> Self {
        match self {
            Self::Message { message, .. } => Self::Message { message, hint: Some(text.into()) },
            other => other,
        }
    }

    /// An input that must have an image or a camera, and has none.
    pub(crate) fn no_file(input: &GraphInput) -> Self {
        let (what, files) = match input.block {
            Some(_) => ("a camera", "a JSON file with its matrices, or an EXR file that states them,"),
            None => ("an image", "an EXR, HDR, PNG or JPEG file"),
        };
        Self::message(format!("the pipeline needs {what} for its input `{}`", input.name))
            .hint(format!("name {files} in the row of this input, under Inputs, or choose another pipeline"))
    }
}

impl From<GpuError> for Problem {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::DeviceLost { .. } => Self::DeviceLost,
            other => Self::message(other.to_string()),
        }
    }
}

impl From<PostError> for Problem {
    fn from(error: PostError) -> Self {
        match error {
            PostError::Gpu(error) => error.into(),
            other => Self::message(other.to_string()),
        }
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Pipeline(diagnostics) => write!(f, "{diagnostics}"),
            Self::Message { message, hint: None } => write!(f, "{message}"),
            Self::Message { message, hint: Some(hint) } => write!(f, "{message}\n  = help: {hint}"),
            Self::DeviceLost => write!(f, "the graphics device was lost"),
        }
    }
}
