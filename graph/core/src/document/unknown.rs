//! The error of a word that a pipeline file may not hold.

use afterimage_base::diagnostic::{Diagnostic, Spanned, list};

/// A word that is not among those known.
pub(super) fn unknown(
    code: &'static str,
    message: String,
    word: &Spanned<String>,
    what: &str,
    known: &[&str],
) -> Diagnostic {
    Diagnostic::error(code, message)
        .at(&word.location, "")
        .help(format!("the {what} are {}", list(known.iter().copied(), known.len())))
        .did_you_mean(&word.value, known.iter().copied())
}
