//! A pipeline and all that it names, as read at one moment.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{Checker, Graph};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::Registry;
use afterimage_pipelines::PIPELINES;

use crate::error::Error;
use crate::files::{Files, or_current};
use crate::kinds::kinds_in;
use crate::source::{Place, Source};

/// A pipeline and all that it names, as read at one moment. Clones share it.
#[derive(Clone)]
pub(crate) struct Snapshot {
    document: Arc<Document>,
    registry: Arc<Registry>,
    files: Arc<Files>,
}

impl Snapshot {
    /// Reads a source by way of its [files](files_of).
    pub(crate) fn read(source: &Source, files: Arc<Files>) -> Result<Self, Error> {
        let (name, text) = match &source.place {
            Place::Text { name, text } => (name.clone(), text.clone()),
            Place::Path(path) => match built_in(path) {
                Some((name, text)) => (format!("{name}.ron"), text.to_owned()),
                None => (path.to_string_lossy().into_owned(), text_of(path, &files)?),
            },
        };
        let mut folders: Vec<&Path> = source.kind_folders.iter().map(PathBuf::as_path).collect();
        folders.extend(folder_of(source));
        let mut kinds = Vec::new();
        for folder in folders {
            kinds.extend(kinds_in(or_current(folder), &files)?);
        }
        let tables = [afterimage_nodes::ALL, afterimage_nodes::HOST, &source.kinds, &kinds];
        let (document, registry) = (parse(&name, &text)?.into(), Registry::new(&tables)?.into());
        Ok(Self { document, registry, files })
    }

    /// The graph at a tier. Warnings are logged.
    pub(crate) fn graph(&self, tier: Option<&str>) -> Result<Graph, Error> {
        let (graph, warnings) = self.checker().check(tier, &[])?;
        if !warnings.is_empty() {
            log::warn!("{warnings}");
        }
        Ok(graph)
    }

    pub(crate) fn tiers(&self) -> Vec<String> {
        self.checker().tiers()
    }

    fn checker(&self) -> Checker<'_> {
        Checker::new(&self.document, &self.registry, &*self.files)
    }
}

/// The files that a source may name.
pub(crate) fn files_of(source: &Source) -> Arc<Files> {
    Files::new(folder_of(source), &source.allowed).into()
}

/// The folder of a source that is a file.
fn folder_of(source: &Source) -> Option<&Path> {
    match &source.place {
        Place::Path(path) if built_in(path).is_none() => Some(path.parent().unwrap_or(Path::new(""))),
        _ => None,
    }
}

/// The name and the text of the built-in pipeline that a path names; a file of that name wins.
fn built_in(path: &Path) -> Option<(&'static str, &'static str)> {
    let name = path.to_str()?;
    let name = name.strip_suffix(".ron").unwrap_or(name);
    let found = PIPELINES.iter().find(|(known, _)| *known == name)?;
    path.symlink_metadata().is_err().then_some(*found)
}

fn text_of(path: &Path, files: &Files) -> Result<String, Error> {
    files.text(path).map_err(|why| {
        let is_name = path.extension().is_none() && path.symlink_metadata().is_err();
        if !is_name {
            return Error::Unreadable(why);
        }
        let names: Vec<&str> = PIPELINES.iter().map(|(name, _)| *name).collect();
        Error::Unreadable(format!("{why}; the built-in pipelines are {}", names.join(", ")))
    })
}
