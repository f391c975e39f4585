//! Why a graph cannot be planned.

use afterimage_base::image::Size;

/// Why a graph cannot be planned for a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlanError {
    /// The host does not give an image that the pipeline needs.
    MissingInput(String),
    /// An image is larger than the device allows.
    TooLarge {
        /// The image, as `node.port`.
        label: String,
        /// Its size.
        size: Size,
        /// The longest side allowed.
        limit: u32,
    },
    /// An output comes from a node that is off and has no fallback.
    NothingToShow(String),
    /// The sizes of images that depend on the previous frame do not settle.
    UnstableHistory(String),
}

impl std::fmt::Display for PlanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::MissingInput(name) => write!(f, "the pipeline needs an image for its input `{name}`"),
            Self::TooLarge { label, size, limit } => {
                write!(f, "image `{label}` is {size}, but this device allows at most {limit} texels a side")
            }
            Self::NothingToShow(name) => {
                write!(f, "output `{name}` comes from a node that is off and has no fallback")
            }
            Self::UnstableHistory(name) => write!(f, "the size of `{name}@previous` grows from frame to frame"),
        }
    }
}

impl std::error::Error for PlanError {}
