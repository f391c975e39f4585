//! Errors of the viewer.

use afterimage::host::PostError;
use afterimage_gpu::GpuError;
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

    pub(crate) fn no_image(input: &str) -> Self {
        Self::message(format!("the pipeline needs an image for its input `{input}`"))
            .hint("drop an EXR, HDR, PNG or JPEG file on the row of this input, or choose another pipeline")
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
