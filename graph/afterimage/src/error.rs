//! Errors of the calls of a host.

use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::node::RegistryError;

use crate::post::PostError;

/// The reason why a call of a host failed. Written, it is a text for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A pipeline or a file that it names is wrong, or has no such tier. Written, each message has its excerpt, with
    /// the wrong place underlined.
    #[error("{0}")]
    Wrong(Diagnostics),
    /// There is no such pipeline, or a file cannot be read or written.
    #[error("{0}")]
    Unreadable(String),
    /// Two node kinds have one name, or a shader of one is wrong.
    #[error(transparent)]
    Kinds(#[from] RegistryError),
    /// The pipeline has no output, fact or node of that name.
    #[error("{0}")]
    Name(String),
    /// An image or a camera in the memory of the processor does not fit.
    #[error("{0}")]
    Image(String),
    /// A name, a value or an image does not fit the pipeline.
    #[error(transparent)]
    Post(#[from] PostError),
    /// The device reports an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

// Clippy warns hosts of functions that return a larger one.
const _: () = assert!(size_of::<Error>() < 128, "the error is small");

#[cfg(all(feature = "offline", not(target_family = "wasm")))]
impl Error {
    /// `true` if another device may succeed.
    pub(crate) fn is_of_device(&self) -> bool {
        let (Self::Gpu(error) | Self::Post(PostError::Gpu(error))) = self else { return false };
        matches!(
            error,
            GpuError::DeviceLost { .. } | GpuError::TimedOut | GpuError::OutOfMemory { .. } | GpuError::Refused { .. }
        )
    }
}

impl From<Diagnostics> for Error {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Wrong(diagnostics)
    }
}
