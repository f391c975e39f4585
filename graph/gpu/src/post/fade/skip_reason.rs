//! Why a change was not faded.

/// Why a change was not faded, or not to its end: see [`Post::fade_skip_reason`](crate::Post::fade_skip_reason).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FadeSkipReason {
    /// The host draws into images of a plan, which it would have to do twice.
    #[error("the host draws into images of the pipeline")]
    HostDraws,
    /// One of the plans has several outputs or none, or the outputs have different names or sizes.
    #[error("the plans do not have one output each, of the same name and size")]
    Outputs,
    /// A pass reads the output after it is written: in the host's image it may have another precision than in ours.
    #[error("a pass reads the output")]
    OutputIsRead,
    /// What earlier frames have left is a depth or multisampled, and is not copied.
    #[error("an image of earlier frames is a depth or multisampled")]
    DepthHistory,
    /// The host gives no view for the output, or one whose texture lacks the usage `RENDER_ATTACHMENT`.
    #[error("the host gives no view of the output with the usage `RENDER_ATTACHMENT`")]
    NotDrawable,
    /// The frame resets histories: the first one, a reset, another device.
    #[error("the frame does not follow one of the old plan")]
    NewBeginning,
    /// The images of the host have other sizes or formats.
    #[error("the images of the host have changed")]
    NewImages,
    /// The host has waited for the change, with [`Post::finish_changes`](crate::Post::finish_changes).
    #[error("the host has waited for the change")]
    Awaited,
    /// The fade was set after the plan was begun.
    #[error("the fade was set after the plan was begun")]
    Late,
    /// The device or the executor refuses what the fade needs, such as memory.
    #[error("{0}")]
    Refused(String),
}
