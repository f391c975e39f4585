//! Node kinds in folders.

use std::path::{Path, PathBuf};

use afterimage_graph::diagnostic::{Diagnostics, shown_path};
use afterimage_graph::node::{NodeKind, folder_kind_sharing};

/// Access to the files of node kinds, with the errors of whoever reads them.
pub trait KindFiles {
    /// The error of a file that cannot be read, or is wrong.
    type Error: From<Diagnostics>;

    /// The paths in a folder, sorted.
    ///
    /// # Errors
    /// The folder cannot be listed.
    fn list(&self, folder: &Path) -> Result<Vec<PathBuf>, Self::Error>;

    /// The text of a file; `what` names it in an error, such as "shader".
    ///
    /// # Errors
    /// The file cannot be read.
    fn text(&self, path: &Path, what: &str) -> Result<String, Self::Error>;

    /// `true` if files beside the folder of a kind may be read.
    fn permits(&self, path: &Path) -> bool;

    /// The error of a folder that cannot be a kind, and what to do about it.
    fn no_kind(&self, message: String, hint: &str) -> Self::Error;
}

/// The name of the folder with the shaders that kinds next to it share.
pub const LIBRARY: &str = "lib";

/// The path of a shader and its text.
type ShaderText = (String, String);

/// The folders whose kinds a pipeline has: those that are named, and the folder of its file. A kind is in one of them.
pub fn kind_folders<'a>(own: Option<&'a Path>, named: &'a [PathBuf]) -> Vec<&'a Path> {
    let own = own.map(or_current).filter(|own| !named.iter().any(|folder| is_among(own, folder)));
    let others = named.iter().map(PathBuf::as_path).filter(|folder| own.is_none_or(|own| !is_among(folder, own)));
    others.chain(own).collect()
}

/// An empty path means the current folder.
pub(crate) fn or_current(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// `true` if a folder is one of a kind.
pub fn is_kind(folder: &Path) -> bool {
    folder.join("node.ron").is_file()
}

/// `true` if the kinds of a folder are read with those of another: it is that folder, or a kind in it.
fn is_among(folder: &Path, other: &Path) -> bool {
    let (Ok(folder), Ok(other)) = (or_current(folder).canonicalize(), or_current(other).canonicalize()) else {
        return false;
    };
    folder == other || !is_kind(&other) && is_kind(&folder) && folder.parent() == Some(&other)
}

/// The kinds of a folder: itself if it has a `node.ron`, or each folder in it that has one. There may be none.
///
/// # Errors
/// A file cannot be read, or a kind is wrong.
pub fn kinds_in<F: KindFiles>(folder: &Path, files: &F) -> Result<Vec<NodeKind>, F::Error> {
    if is_kind(folder) {
        let beside = std::fs::canonicalize(folder).ok().and_then(|real| real.parent().map(Path::to_owned));
        let beside = beside.filter(|parent| files.permits(&parent.join(LIBRARY)));
        let library = beside.map_or(Ok(Vec::new()), |parent| library_in(&parent, files))?;
        return Ok(vec![kind(folder, &library, files)?]);
    }
    let mut folders = files.list(folder)?;
    folders.retain(|path| is_kind(path));
    if folders.is_empty() {
        return Ok(Vec::new());
    }
    let library = library_in(folder, files)?;
    folders.iter().map(|folder| kind(folder, &library, files)).collect()
}

/// The shaders that the kinds of a folder share, if they share any.
fn library_in<F: KindFiles>(folder: &Path, files: &F) -> Result<Vec<ShaderText>, F::Error> {
    let library = folder.join(LIBRARY);
    let is_library = library.is_dir() && !is_kind(&library);
    if is_library { shaders_of(&library, files) } else { Ok(Vec::new()) }
}

fn kind<F: KindFiles>(folder: &Path, library: &[ShaderText], files: &F) -> Result<NodeKind, F::Error> {
    let path = folder.join("node.ron");
    let declaration = files.text(&path, "node kind")?;
    let shaders = shaders_of(folder, files)?;
    if shaders.is_empty() {
        let message = format!("`{}` has no `.wgsl` or `.wesl` file beside its `node.ron`", shown_path(folder));
        let hint = "a kind's shader is called like the kind in snake case: `posterize.wgsl` for `Posterize`";
        return Err(files.no_kind(message, hint));
    }
    Ok(folder_kind_sharing((&path.to_string_lossy(), &declaration), &borrowed(&shaders), &borrowed(library))?)
}

fn borrowed(shaders: &[ShaderText]) -> Vec<(&str, &str)> {
    shaders.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect()
}

/// The `.wesl` and `.wgsl` files of a folder. Of two with one name, the first is found, as in WESL.
fn shaders_of<F: KindFiles>(folder: &Path, files: &F) -> Result<Vec<ShaderText>, F::Error> {
    let mut paths = files.list(folder)?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "wgsl" || ending == "wesl"));
    paths.into_iter().map(|path| Ok((path.to_string_lossy().into_owned(), files.text(&path, "shader")?))).collect()
}
