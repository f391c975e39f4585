//! Errors of the calls of a host.

use afterimage_gpu::GpuError;
use afterimage_graph::diagnostic::quote;
use afterimage_plan::PlanError;

/// The reason why a host's call failed.
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
