//! Files in memory, for hosts that load asynchronously.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{Checker, Loader};
use crate::document::Document;
use crate::node::Registry;

/// Files that a host has loaded, by their joined paths, for hosts that load asynchronously: it asks which are
/// [missing](Self::missing), loads them, and asks again, because files name further files.
///
/// ```
/// use afterimage_graph::check::{CheckOptions, LoadedFiles, check};
/// # let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
/// # let load = |path: &str| match path {
/// #     "looks/base.ron" => Ok(br#"Pipeline(inputs: { "scene": Color },
/// #         nodes: { "exposed": Exposure(source: "scene") }, outputs: { "display": "exposed" })"#.as_slice().into()),
/// #     _ => Err("there is no such file".to_owned()),
/// # };
/// let text = r#"Pipeline(extends: "base.ron", set: { "exposed.stops": 1.0 })"#;
/// let document = afterimage_graph::document::parse("looks/bright.ron", text)?;
/// let mut files = LoadedFiles::default();
/// loop {
///     let missing = files.missing(&document, &registry);
///     if missing.is_empty() {
///         break;
///     }
///     for path in missing {
///         let bytes = load(&path);
///         files.insert(path, bytes);
///     }
/// }
/// let (graph, _warnings) = check(&document, &registry, &CheckOptions { loader: &files, ..CheckOptions::default() })?;
/// assert_eq!(graph.nodes.len(), 1);
/// # Ok::<(), afterimage_graph::diagnostic::Diagnostics>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct LoadedFiles {
    loaded: BTreeMap<String, Result<Arc<[u8]>, String>>,
}

impl LoadedFiles {
    /// Keeps the bytes of a file, or why there are none: a check then reports it where the file is named.
    pub fn insert(&mut self, path: String, bytes: Result<Arc<[u8]>, String>) {
        self.loaded.insert(path, bytes);
    }

    /// The files that there are.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Arc<[u8]>)> {
        self.loaded.iter().filter_map(|(path, bytes)| Some((path.as_str(), bytes.as_ref().ok()?)))
    }

    /// The paths of files that the document and the files so far name and that are not loaded, in all tiers. Paths are
    /// joined to the folder of the file that names them. Each call checks the document.
    pub fn missing(&self, document: &Document, registry: &Registry) -> BTreeSet<String> {
        let loader = RecordingLoader { files: self, missing: RefCell::default() };
        let checker = Checker::new(document, registry, &loader);
        // Errors are those of the check that the host makes when it has all files.
        let tiers = checker.tiers();
        for tier in std::iter::once(None).chain(tiers.iter().map(|tier| Some(tier.as_str()))) {
            drop(checker.check(tier, &[]));
        }
        loader.missing.into_inner()
    }
}

impl Loader for LoadedFiles {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.loaded.get(path).cloned().unwrap_or_else(|| Err("it is not loaded".into()))
    }
}

/// Notes the files that are not there.
struct RecordingLoader<'f> {
    files: &'f LoadedFiles,
    missing: RefCell<BTreeSet<String>>,
}

impl Loader for RecordingLoader<'_> {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        if !self.files.loaded.contains_key(path) {
            self.missing.borrow_mut().insert(path.to_owned());
        }
        self.files.load(path)
    }
}
