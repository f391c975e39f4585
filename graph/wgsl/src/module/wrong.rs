//! An error in the syntax of a file.

/// Error of a file, with the index of a token.
#[derive(Debug)]
pub(super) struct Wrong {
    pub(super) token: usize,
    pub(super) message: String,
    pub(super) help: Option<&'static str>,
}
