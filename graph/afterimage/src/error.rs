//! Why a call of a host failed.

use afterimage_gpu::{GpuError, PostError};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::node::RegistryError;

/// Why a call of a host failed. Written, it is a text for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A pipeline or a file that it names is wrong, or has no such tier. Written, each message has its excerpt, with
    /// the wrong place underlined.
    #[error("{0}")]
    Wrong(Diagnostics),
    /// There is no such pipeline, or a file cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// Two node kinds have one name, or a shader of one is wrong.
    #[error(transparent)]
    Kinds(#[from] RegistryError),
    /// A name, a value or an image does not fit the pipeline.
    #[error(transparent)]
    Post(#[from] PostError),
    /// The device reports an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl From<Diagnostics> for Error {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Wrong(diagnostics)
    }
}
