//! A pipeline and all that it names, as read at one moment.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{Checker, Graph};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::Registry;

use crate::error::Error;
use crate::files::{Files, or_current};
use crate::kinds::{KindFiles as _, kinds_in};
use crate::source::{Place, Source, built_in, built_in_hint};

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
        let own = folder_of(source).map(or_current);
        let named = source.kind_folders.iter().map(PathBuf::as_path);
        let folders = named.filter(|folder| own.is_none_or(|own| !is_among(folder, own))).chain(own);
        let mut kinds = Vec::new();
        for folder in folders {
            kinds.extend(kinds_in(or_current(folder), &*files)?);
        }
        let tables = [afterimage_nodes::ALL, afterimage_nodes::HOST, &source.kinds, &kinds];
        let (document, registry) = (parse(&name, &text)?.into(), Registry::new(&tables)?.into());
        Ok(Self { document, registry, files })
    }

    /// The graph at a tier. Warnings are logged.
    pub(crate) fn graph(&self, tier: Option<&str>) -> Result<Graph, Error> {
        let (graph, warnings) = self.check(tier, &[])?;
        if !warnings.is_empty() {
            log::warn!("{warnings}");
        }
        Ok(graph)
    }

    /// The graph at a tier with changed parameters, and the warnings.
    pub(crate) fn check(&self, tier: Option<&str>, sets: &[(String, String)]) -> Result<(Graph, Diagnostics), Error> {
        Ok(self.checker().check(tier, sets)?)
    }

    pub(crate) fn tiers(&self) -> Vec<String> {
        self.checker().tiers()
    }

    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(crate) fn registry(&self) -> &Registry {
        &self.registry
    }

    fn checker(&self) -> Checker<'_> {
        Checker::new(&self.document, &self.registry, &*self.files)
    }
}

/// Whether the kinds of a folder are read with those of `own`: it is that folder, or a kind in it.
fn is_among(folder: &Path, own: &Path) -> bool {
    let (Ok(folder), Ok(own)) = (folder.canonicalize(), own.canonicalize()) else { return false };
    let is_kind = |folder: &Path| folder.join("node.ron").is_file();
    folder == own || !is_kind(&own) && is_kind(&folder) && folder.parent() == Some(&own)
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

fn text_of(path: &Path, files: &Files) -> Result<String, Error> {
    if path.extension().is_none() && path.symlink_metadata().is_err() {
        let message = format!("there is no pipeline `{}`\n  hint: {}", path.display(), built_in_hint());
        return Err(Error::Unreadable(message));
    }
    files.text(path, "pipeline")
}
