//! Changes of the file that meet changes of the user.

use super::Target;

/// The file was changed where the user has changed something, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Conflict {
    /// The text: what the file has now.
    Text(String),
    /// The values of these targets. The text of the file is already shown.
    Values(Vec<Target>),
}

/// How a conflict is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// The user's text or values stay, and the next save writes them.
    KeepMine,
    /// The file's text or values are shown. Undo goes back to the user's.
    TakeFile,
}
