//! The words of a command line that name pipelines: built-in ones, and files.

use std::path::Path;

use afterimage_media::read_text;
use afterimage_pipelines::PIPELINES;

/// The most bytes of a pipeline, a declaration or a shader.
pub(crate) const MAX_TEXT: u64 = 16 << 20;

/// The name and the text of the built-in pipeline that a word of the command line names; a file of that name wins.
pub(crate) fn built_in(path: &Path) -> Option<(&'static str, &'static str)> {
    let name = path.to_str()?;
    let name = name.strip_suffix(".ron").unwrap_or(name);
    let found = PIPELINES.iter().find(|(known, _)| *known == name)?;
    // Also a link in a circle, which is reported.
    path.symlink_metadata().is_err().then_some(*found)
}

/// Whether a word of the command line names a pipeline: a built-in one, or a file of that ending or with such a text.
pub(crate) fn is_pipeline(path: &Path) -> bool {
    let has_text = || read_text(path, MAX_TEXT).is_ok_and(|text| text.contains("Pipeline("));
    path.extension().is_some_and(|ending| ending == "ron") || built_in(path).is_some() || has_text()
}

/// The names of all built-in pipelines as a hint.
pub(crate) fn hint() -> String {
    let names: Vec<&str> = PIPELINES.iter().map(|(name, _)| *name).collect();
    format!("name a .ron file, or one of the built-in pipelines: {}", names.join(", "))
}
