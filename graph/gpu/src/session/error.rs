//! Errors of sessions.

use afterimage_plan::PlanError;

use crate::GpuError;

/// Why a session could not render.
#[derive(Debug, Clone, thiserror::Error)]
pub enum SessionError {
    /// The graph cannot be planned for these images.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device or the executor reports an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
