//! New files for pipelines that have none, such as the built-in ones.

use std::path::{Path, PathBuf};

use crate::Problem;
use crate::model::{NamedFile, Project};

/// Makes the place that a pipeline is written to, by its path and the files that it names, which are written with it.
pub type MakeProject = Box<dyn Fn(&Path, Vec<NamedFile>) -> Result<Box<dyn Project>, Problem>>;

/// Storage of pipelines that have no file.
pub enum NewFiles {
    /// The user is asked for a path, at which nothing may be yet.
    Asked(MakeProject),
    /// The browser stores it under its name.
    Downloaded(MakeProject),
}

/// A file that the user wants to choose in a dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// A pipeline to open.
    Pipeline,
    /// The file of an input, by the usual endings of such files.
    Input { name: String, endings: Vec<&'static str> },
}

/// The question for the path of a file, while it is open.
pub(super) struct NewFile {
    pub(super) path: String,
    pub(super) new_tier: Option<String>,
    pub(super) error: Option<String>,
    /// The field has had the focus, which it gets once for each attempt.
    pub(super) was_focused: bool,
}

/// The name, with a number where a file of that name is there.
pub(crate) fn free_name(name: &str) -> PathBuf {
    let (stem, ending) = name.rsplit_once('.').unwrap_or((name, ""));
    let numbered = (2..).map(|number| PathBuf::from(format!("{stem}-{number}.{ending}")));
    let mut names = std::iter::once(PathBuf::from(name)).chain(numbered);
    names.find(|path| path.symlink_metadata().is_err()).expect("one of endless names is free")
}
