//! Why a graph cannot be planned.

use afterimage_base::image::Size;

/// Why a graph cannot be planned for a request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The host does not give an image that the pipeline needs.
    #[error("the pipeline needs an image for its input `{0}`")]
    MissingInput(String),
    /// An image is larger than the device allows.
    #[error("image `{label}` is {size}, but this device allows at most {limit} texels a side")]
    TooLarge {
        /// The image, as `node.port`.
        label: String,
        /// Its size.
        size: Size,
        /// The longest side allowed.
        limit: u32,
    },
    /// An output comes from a node that is off and has no fallback.
    #[error("output `{0}` comes from a node that is off and has no fallback")]
    NothingToShow(String),
    /// The sizes of images that depend on the previous frame do not settle.
    #[error("the size of `{0}@previous` grows from frame to frame")]
    UnstableHistory(String),
}
