//! Words of a command line that name pipelines.

use std::path::{Path, PathBuf};

use afterimage::host::{built_in, built_in_hint};
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_media::read_text;
use afterimage_pipelines::PIPELINES;

/// The most bytes of a pipeline, a declaration or a shader.
pub(crate) const MAX_TEXT: u64 = 16 << 20;

/// True if a word of the command line names a pipeline: a built-in one, or a file of that ending or with such a text.
pub(crate) fn is_pipeline(path: &Path) -> bool {
    let has_text = || read_text(path, MAX_TEXT).is_ok_and(|text| text.contains("Pipeline("));
    path.extension().is_some_and(|ending| ending == "ron") || built_in(path).is_some() || has_text()
}

/// Exchanges a pipeline and an image if they stand the other way round.
pub(crate) fn put_in_order(pipeline: &mut PathBuf, image: &mut Option<String>) {
    if let Some(input) = image
        && !is_pipeline(pipeline)
        && is_pipeline(Path::new(input))
        && let Some(first) = pipeline.to_str()
    {
        (*image, *pipeline) = (Some(first.to_owned()), PathBuf::from(&*input));
    }
}

/// The built-in pipeline that a wrong name may mean, or the names of all, as a hint.
pub(crate) fn hint(wrong: &str) -> String {
    did_you_mean(wrong, PIPELINES.iter().map(|(name, _)| *name)).unwrap_or_else(built_in_hint)
}
