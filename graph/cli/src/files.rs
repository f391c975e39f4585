//! Reads the files of the command line: pipelines and folders of node kinds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::Loader;
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::{NodeKind, Registry, folder_kind_of};

use crate::failure::Failure;

/// Reads the files that a pipeline names.
pub(crate) struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| why_not(Path::new(path), &error))
    }
}

/// The text of a file; `what` names it in the error.
pub(crate) fn read_text(path: &Path, what: &str) -> Result<String, Failure> {
    let failed = |why: String| Failure::unreadable(format!("cannot read the {what} `{}`: {why}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failed(why_not(path, &error)))?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|byte| **byte == b'\n').count() + 1;
        failed(format!("line {line} is not text in UTF-8")).hint("save the file in that encoding")
    })
}

/// Why a file cannot be read.
fn why_not(path: &Path, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    // An empty path names the current folder.
    if path.is_dir() || path.as_os_str().is_empty() {
        return "it is a folder".into();
    }
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "you may not read it".into(),
        _ => error.to_string(),
    }
}

/// The kinds of the program and of plug-in folders.
pub(crate) fn registry(tables: &[&[NodeKind]], folders: &[PathBuf]) -> Result<Registry, Failure> {
    let mut from_folders = Vec::new();
    for folder in folders {
        from_folders.extend(folder_kinds(folder)?);
    }
    let mut all = tables.to_vec();
    all.push(&from_folders);
    let hint = "a kind of `--nodes` needs a name that no other kind has; `afterimage nodes` lists the built-in ones";
    Registry::new(&all).map_err(|error| Failure::user(error).hint(hint))
}

/// The kinds in a folder: the folder itself if it has a `node.ron`, or each folder in it that has one.
pub(crate) fn folder_kinds(folder: &Path) -> Result<Vec<NodeKind>, Failure> {
    if folder.join("node.ron").is_file() {
        return Ok(vec![folder_node(folder)?]);
    }
    let entries = std::fs::read_dir(folder)
        .map_err(|error| Failure::unreadable(format!("`{}` has no node kinds: {error}", folder.display())))?;
    let mut folders: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.retain(|path| path.join("node.ron").is_file());
    folders.sort();
    if folders.is_empty() {
        return Err(Failure::user(format!("no folder in `{}` has a `node.ron`", folder.display())));
    }
    folders.iter().map(|folder| folder_node(folder)).collect()
}

fn folder_node(folder: &Path) -> Result<NodeKind, Failure> {
    let ron_path = folder.join("node.ron");
    let ron = read_text(&ron_path, "node kind")?;
    let mut shaders = Vec::new();
    for path in shaders_of(folder)? {
        shaders.push((path.to_string_lossy().into_owned(), read_text(&path, "shader")?));
    }
    let shaders: Vec<(&str, &str)> = shaders.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    Ok(folder_kind_of((&ron_path.to_string_lossy(), &ron), &shaders)?)
}

/// The `.wgsl` files of a folder: the kind's own and those that it imports.
fn shaders_of(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| Failure::user(format!("`{}`: {error}", folder.display())))?;
    let mut shaders: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    shaders.retain(|path| path.extension().is_some_and(|ending| ending == "wgsl"));
    shaders.sort();
    if shaders.is_empty() {
        return Err(Failure::user(format!("`{}` has no `.wgsl` file beside its `node.ron`", folder.display()))
            .hint("a kind's shader is called like the kind in snake case: `posterize.wgsl` for `Posterize`"));
    }
    Ok(shaders)
}

/// Reads and parses a pipeline file.
pub(crate) fn read_document(path: &Path) -> Result<Document, Failure> {
    Ok(parse(&path.to_string_lossy(), &read_text(path, "pipeline")?)?)
}
