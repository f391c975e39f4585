//! Words that a RON file may not hold: keys that had another name before, removed options, and all unknown ones.
//! Parameters of kinds declare their former names by `formerly`.

use afterimage_base::diagnostic::{Diagnostic, Spanned, list, quote};

/// What has the key, the key's former name and its present one. A further rename is a further line here.
const RENAMED: [(&str, &str, &str); 2] = [("an input", "states", "accepts"), ("an output", "gives", "state")];

/// What had the key, the key, and where it stands now.
const MOVED: [(&str, &str, &str); 2] = [
    ("a node file", "fallback", "write it in each output: `\"result\": Image(doc: \"...\", fallback: Zero, ...)`"),
    (
        "a node file",
        "bypass",
        "write `fallback` in each output: `\"result\": Image(doc: \"...\", fallback: Zero, ...)`",
    ),
];

/// Options of inputs that were removed, and what to do instead.
const REMOVED: [(&str, &str); 1] = [(
    "allow_negative",
    "remove it: the type says whether numbers may be negative; `Color`, `Exposed`, `LogLuminance` and `Data` keep them",
)];

/// The error of an option of an input that was removed; `None` for any other.
pub(crate) fn removed(option: &Spanned<String>) -> Option<Diagnostic> {
    let (_, why) = REMOVED.iter().find(|(former, _)| *former == option.value)?;
    let message = format!("the option {} is gone", quote(&option.value));
    Some(Diagnostic::error("removed-key", message).at(&option.location, "").help(*why))
}

/// The present name of a key, if it was renamed.
pub(crate) fn present_name(owner: &str, key: &str) -> Option<&'static str> {
    RENAMED.iter().find(|(of, former, _)| *of == owner && *former == key).map(|(.., present)| *present)
}

/// The error of a key that stands elsewhere now; `None` for any other.
pub(crate) fn moved(owner: &str, key: &Spanned<String>) -> Option<Diagnostic> {
    let (.., help) = MOVED.iter().find(|(of, former, _)| *of == owner && *former == key.value)?;
    let message = format!("{owner} has no field {} any more", quote(&key.value));
    Some(Diagnostic::error("moved-key", message).at(&key.location, "").help(*help))
}

/// The error of a key with its former name.
pub(crate) fn renamed(key: &Spanned<String>, present: &str) -> Diagnostic {
    Diagnostic::error("renamed-key", format!("{} is called {} now", quote(&key.value), quote(present)))
        .at(&key.location, "")
        .help(format!("write {}", quote(present)))
        .correct(&key.value, present)
}

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
