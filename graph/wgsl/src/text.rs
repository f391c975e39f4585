//! Text that lives as long as the program, or as long as somebody holds it.

use std::ops::Deref;
use std::sync::Arc;

/// A name or the text of a file; a copy shares its characters.
#[derive(Clone)]
pub(crate) enum Text {
    /// Part of the program.
    Static(&'static str),
    /// Read while the program runs.
    Shared(Arc<str>),
}

impl Deref for Text {
    type Target = str;

    fn deref(&self) -> &str {
        match self {
            Self::Static(text) => text,
            Self::Shared(text) => text,
        }
    }
}

impl From<&'static str> for Text {
    fn from(text: &'static str) -> Self {
        Self::Static(text)
    }
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self::Shared(text.into())
    }
}

impl std::fmt::Debug for Text {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}
