//! Why a call of a host failed.

use afterimage_plan::PlanError;

use crate::error::GpuError;

/// Why a host's call failed.
#[derive(Debug, Clone, thiserror::Error)]
pub enum PostError {
    /// The graph cannot be planned for these images.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device or the executor reports an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The pipeline has no such parameter.
    #[error("{0}")]
    UnknownParameter(String),
    /// The parameter has another type.
    #[error("`{name}` is {ty}")]
    WrongType {
        /// The parameter, as `node.parameter`.
        name: String,
        /// Its type in words.
        ty: String,
    },
    /// The value is outside of the domain, or does not go with the values of other parameters.
    #[error("`{name}`: {why}")]
    Refused {
        /// The parameter, as `node.parameter`.
        name: String,
        /// The reason.
        why: String,
    },
}
