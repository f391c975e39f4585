//! Folders and names of result files.

use std::path::Path;

use afterimage_graph::diagnostic::shown_path;

use crate::LabError;

/// The most bytes of a result file that is read again.
pub(crate) const MAX_TEXT: u64 = 64 << 20;

/// Makes a folder and those above it.
pub(crate) fn make_folder(folder: &Path) -> Result<(), LabError> {
    std::fs::create_dir_all(folder)
        .map_err(|error| LabError::Machine(format!("cannot make the folder `{}`: {error}", shown_path(folder))))
}

/// Compares the extension of a file, ignoring case.
pub(crate) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// A name with `-` in place of the characters that file systems do not allow.
pub(crate) fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || matches!(c, '.' | '-' | '=') { c } else { '-' }).collect()
}
