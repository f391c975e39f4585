//! Options of a check.

use std::sync::Arc;

/// Reads files for the check, which does no input or output of its own.
pub trait Loader {
    /// The bytes of a file, or why there are none. Paths are relative to the file that names them, already joined to
    /// its folder.
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String>;

    /// The bytes of a file that the user names by an override of [`CheckOptions::sets`]. A loader that restricts what a
    /// pipeline may name need not restrict these.
    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.load(path)
    }
}

/// A loader for hosts without files: every path is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Loader for NoFiles {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Err("this program gives pipelines no access to files".into())
    }
}

/// Options of a single check.
#[derive(Clone)]
pub struct CheckOptions<'a> {
    /// The quality level, one of the document's `tiers`.
    pub tier: Option<String>,
    /// Overrides in the order in which they are applied: `node.parameter` and a value as in a pipeline file.
    pub sets: Vec<(String, String)>,
    /// Source of the files that a pipeline names.
    pub loader: &'a dyn Loader,
}

impl Default for CheckOptions<'_> {
    fn default() -> Self {
        Self { tier: None, sets: Vec::new(), loader: &NoFiles }
    }
}
