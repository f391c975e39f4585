//! Node kinds in folders.

use std::path::{Path, PathBuf};

use afterimage_graph::node::{NodeKind, folder_kind_sharing};

use crate::error::Error;
use crate::files::Files;

/// The name of the folder with the shaders that kinds next to it share.
const LIBRARY: &str = "lib";

/// The path of a shader and its text.
type ShaderText = (String, String);

/// The kinds of a folder: itself if it has a `node.ron`, or each folder in it that has one. There may be none.
pub(crate) fn kinds_in(folder: &Path, files: &Files) -> Result<Vec<NodeKind>, Error> {
    if folder.join("node.ron").is_file() {
        let beside = std::fs::canonicalize(folder).ok().and_then(|real| real.parent().map(Path::to_owned));
        let library = beside.map_or(Ok(Vec::new()), |parent| library_in(&parent, files))?;
        return Ok(vec![kind(folder, &library, files)?]);
    }
    let mut folders = files.list(folder).map_err(Error::Unreadable)?;
    folders.retain(|path| path.join("node.ron").is_file());
    if folders.is_empty() {
        return Ok(Vec::new());
    }
    let library = library_in(folder, files)?;
    folders.iter().map(|folder| kind(folder, &library, files)).collect()
}

/// The shaders that the kinds of a folder share, if they share any.
fn library_in(folder: &Path, files: &Files) -> Result<Vec<ShaderText>, Error> {
    let library = folder.join(LIBRARY);
    let is_library = library.is_dir() && !library.join("node.ron").is_file();
    if is_library { shaders_of(&library, files) } else { Ok(Vec::new()) }
}

fn kind(folder: &Path, library: &[ShaderText], files: &Files) -> Result<NodeKind, Error> {
    let path = folder.join("node.ron");
    let declaration = files.text(&path).map_err(Error::Unreadable)?;
    let shaders = shaders_of(folder, files)?;
    if shaders.is_empty() {
        return Err(Error::Unreadable(format!("`{}` has no `.wgsl` file beside its `node.ron`", folder.display())));
    }
    Ok(folder_kind_sharing((&path.to_string_lossy(), &declaration), &borrowed(&shaders), &borrowed(library))?)
}

fn borrowed(shaders: &[ShaderText]) -> Vec<(&str, &str)> {
    shaders.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect()
}

/// The `.wgsl` files of a folder.
fn shaders_of(folder: &Path, files: &Files) -> Result<Vec<ShaderText>, Error> {
    let mut paths: Vec<PathBuf> = files.list(folder).map_err(Error::Unreadable)?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "wgsl"));
    let mut shaders = Vec::new();
    for path in paths {
        let text = files.text(&path).map_err(Error::Unreadable)?;
        shaders.push((path.to_string_lossy().into_owned(), text));
    }
    Ok(shaders)
}
