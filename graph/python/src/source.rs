//! Where pipelines come from: the built-in ones, files, texts.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::Loader;
use afterimage_graph::document::{Document, parse};
use afterimage_media::{read_bytes, read_text, real_path};
use afterimage_pipelines::{BuiltIn, PIPELINES};
use pyo3::pyfunction;

use crate::error::Failure;

/// The most bytes of a pipeline.
const MAX_TEXT: u64 = 16 << 20;
/// The most bytes of a file that a pipeline names. The largest table has about 450 MiB as text.
const MAX_FILE: u64 = 1 << 30;

/// The names and the texts of the built-in pipelines.
#[pyfunction]
pub(crate) fn built_in() -> Vec<(&'static str, &'static str)> {
    PIPELINES.to_vec()
}

/// Reads the files that a pipeline names.
pub(crate) enum Files {
    /// Those of a built-in pipeline or of a text: the built-in ones.
    BuiltIn,
    /// Those of this folder, which is a path without links, and below.
    Folder(PathBuf),
}

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        match self {
            Self::BuiltIn => BuiltIn.load(path),
            Self::Folder(folder) => {
                let real = real_path(Path::new(path)).map_err(|error| error.message)?;
                if !real.starts_with(folder) {
                    return Err("only files in the folder of the pipeline and below are read".to_owned());
                }
                bytes(&real)
            }
        }
    }

    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        bytes(Path::new(path))
    }
}

fn bytes(path: &Path) -> Result<Arc<[u8]>, String> {
    Ok(read_bytes(path, MAX_FILE).map_err(|error| error.message)?.into())
}

/// A parsed pipeline, its name, and the files that it may name.
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) document: Document,
    pub(crate) files: Files,
}

impl Source {
    /// Parses a text with `Pipeline(`, the built-in pipeline of a name, or the file of a path. A file wins over a
    /// built-in pipeline of its name.
    pub(crate) fn open(source: &str) -> Result<Self, Failure> {
        if source.contains("Pipeline(") {
            let name = "<text>".to_owned();
            return Ok(Self { document: parse(&name, source)?, files: Files::BuiltIn, name });
        }
        let path = Path::new(source);
        let known = source.strip_suffix(".ron").unwrap_or(source);
        let built_in = PIPELINES.iter().find(|(name, _)| *name == known);
        if let Some((name, text)) = built_in.filter(|_| path.symlink_metadata().is_err()) {
            let document = parse(&format!("{name}.ron"), text)?;
            return Ok(Self { document, files: Files::BuiltIn, name: (*name).to_owned() });
        }
        if path.symlink_metadata().is_err() {
            return Err(missing(source));
        }
        let text = read_text(path, MAX_TEXT)?;
        let folder = real_path(path.parent().unwrap_or(Path::new("")))?;
        Ok(Self { document: parse(source, &text)?, files: Files::Folder(folder), name: source.to_owned() })
    }
}

fn missing(source: &str) -> Failure {
    let names = || PIPELINES.iter().map(|(name, _)| *name);
    let meant = afterimage_graph::diagnostic::did_you_mean(source, names());
    let meant = meant.map_or(String::new(), |meant| format!("; {meant}"));
    let known: Vec<&str> = names().collect();
    let known = known.join(", ");
    Failure::File(format!("there is no pipeline {source:?}{meant}\n  hint: name a file, or one of {known}"))
}
