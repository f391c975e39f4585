//! Errors of measurements.

use afterimage::host::PostError;
use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_media::FileError;
use afterimage_plan::PlanError;

/// The reason why nothing could be measured.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// The request cannot be met: an unknown output, images of different sizes.
    #[error("{message}")]
    Request {
        /// The problem: lower case, no full stop.
        message: String,
        /// The remedy for the user, if one is known.
        hint: Option<String>,
    },
    /// The machine reports an error: a folder that cannot be made, a picture that cannot be drawn.
    #[error("{0}")]
    Machine(String),
    /// An image or a result file.
    #[error(transparent)]
    File(#[from] FileError),
    /// A pipeline that is not valid.
    #[error(transparent)]
    Pipeline(#[from] Diagnostics),
    /// The planner or the device.
    #[error(transparent)]
    Post(#[from] PostError),
}

impl LabError {
    /// A request that cannot be met, without a hint.
    pub fn request(message: impl Into<String>) -> Self {
        Self::Request { message: message.into(), hint: None }
    }

    /// Adds what the user can do.
    pub(crate) fn hint(self, text: impl Into<String>) -> Self {
        match self {
            Self::Request { message, .. } => Self::Request { message, hint: Some(text.into()) },
            other => other,
        }
    }
}

impl From<GpuError> for LabError {
    fn from(error: GpuError) -> Self {
        Self::Post(error.into())
    }
}

impl From<PlanError> for LabError {
    fn from(error: PlanError) -> Self {
        Self::Post(error.into())
    }
}
