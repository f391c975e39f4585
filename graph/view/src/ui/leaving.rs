//! Whether the window is to be closed.

/// Whether the window is to be closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum QuitPrompt {
    /// It stays.
    #[default]
    Stays,
    /// The user is asked whether to save the changes.
    Asks,
    /// It is closed.
    Leaves,
}
