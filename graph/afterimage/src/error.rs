//! Errors of the calls of a host.

use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::{Diagnostics, quote};
use afterimage_graph::node::RegistryError;
use afterimage_plan::PlanError;

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

/// The reason why a call of a [`Post`](crate::Post) failed that needs no files.
#[derive(Debug, Clone, thiserror::Error)]
pub enum PostError {
    /// The graph cannot be planned for these images.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The frame has no image for an input that the pipeline needs.
    #[error("the pipeline needs an image for its input `{input}`{}", given_instead(.given.as_deref()))]
    MissingInput {
        /// The input.
        input: String,
        /// An image of the frame that the pipeline does not know, and that may be meant.
        given: Option<String>,
    },
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
    /// The handle is of another pipeline, or of another view that has made it by itself. It has the name for which it
    /// was made, if that pipeline still exists.
    #[error("the handle{} is not of this pipeline: ask it for the parameter by its name", of(.0.as_deref()))]
    UnknownHandle(Option<String>),
    /// There is no tier to choose from.
    #[error("a budget needs at least one tier to choose from")]
    NoTier,
    /// More frames are announced than plans are kept.
    #[error("{given} frames are announced, and plans are prepared for at most {most}")]
    TooManyFrames {
        /// The number of frames.
        given: usize,
        /// The most that can be.
        most: usize,
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

fn of(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!(" of {}", quote(name)))
}

fn given_instead(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!("; the frame has {}, which the pipeline does not know", quote(name)))
}
