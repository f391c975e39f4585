//! A pipeline and all that it names, as read at one moment.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{Checker, Graph, LoadedFiles, Loader};
use afterimage_graph::diagnostic::{Diagnostics, shown_path};
use afterimage_graph::document::{Claim, Document, parse};
use afterimage_graph::node::{NodeKind, Registry};

use crate::error::Error;
use crate::files::Files;
use crate::governor::{GovernedTier, Governor, TierLimits};
use crate::kinds::{kind_folders, kinds_in, or_current};
use crate::source::{Place, Source, built_in, built_in_hint};

/// A pipeline and all that it names, as read at one moment. Clones share it.
///
/// A host that loads files by itself, such as an engine with assets, makes one of what it has loaded, and a
/// [`Post`](crate::Post) of that:
///
/// ```
/// use afterimage::host::Snapshot;
///
/// # fn run() -> Result<(), afterimage::Error> {
/// # let load = |_: &str| Err("there is no such file".to_owned());
/// let mut snapshot = Snapshot::of_text("look.ron", r#"Pipeline(extends: "base.ron")"#, &[])?;
/// loop {
///     // Files name further files.
///     let missing = snapshot.missing();
///     if missing.is_empty() {
///         break;
///     }
///     for path in missing {
///         let bytes = load(&path);
///         snapshot.insert(path, bytes);
///     }
/// }
/// assert!(snapshot.check(None, &[]).is_err(), "there is no such file");
/// # Ok(())
/// # }
/// # run().expect("the text is a pipeline");
/// ```
#[derive(Clone)]
pub struct Snapshot {
    document: Arc<Document>,
    #[cfg_attr(
        any(not(feature = "offline"), target_family = "wasm"),
        allow(dead_code, reason = "it is for captured frames")
    )]
    text: Arc<str>,
    registry: Arc<Registry>,
    files: FilesOf,
}

/// The source of the files of a snapshot.
#[derive(Clone)]
enum FilesOf {
    Disk(Arc<Files>),
    Host(Arc<LoadedFiles>),
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
        let mut kinds = Vec::new();
        for folder in kind_folders(folder_of(source), &source.kind_folders) {
            kinds.extend(kinds_in(or_current(folder), &*files)?);
        }
        Self::new(&name, &text, &[&source.kinds, &kinds], FilesOf::Disk(files))
    }

    /// A pipeline as text, with node kinds beside the built-in ones. `name` is for errors, and the files that the text
    /// names are sought in its folder. All of them are [missing](Self::missing).
    ///
    /// # Errors
    /// The text is no pipeline, or two kinds have one name.
    pub fn of_text(name: &str, text: &str, kinds: &[NodeKind]) -> Result<Self, Error> {
        Self::new(name, text, &[kinds], FilesOf::Host(Arc::default()))
    }

    fn new(name: &str, text: &str, kinds: &[&[NodeKind]], files: FilesOf) -> Result<Self, Error> {
        let tables: Vec<&[NodeKind]> =
            [afterimage_nodes::ALL, afterimage_nodes::HOST].into_iter().chain(kinds.iter().copied()).collect();
        let (document, registry) = (parse(name, text)?.into(), Registry::new(&tables)?.into());
        Ok(Self { document, text: text.into(), registry, files })
    }

    /// The pipeline itself, and then all files that it names, by their paths.
    pub fn files(&self) -> Vec<(PathBuf, Arc<[u8]>)> {
        let own = Path::new(&*self.document.file);
        let others = match &self.files {
            FilesOf::Disk(files) => files.all(),
            FilesOf::Host(files) => files.iter().map(|(path, bytes)| (path.into(), bytes.clone())).collect(),
        };
        let others = others.into_iter().filter(|(path, _)| path != own);
        std::iter::once((own.to_owned(), self.text.as_bytes().into())).chain(others).collect()
    }

    /// The paths of files that the pipeline and its files so far name, and that the host has not
    /// [inserted](Self::insert): [`LoadedFiles::missing`]. None for a pipeline that was read from a disk.
    pub fn missing(&self) -> BTreeSet<String> {
        match &self.files {
            FilesOf::Disk(_) => BTreeSet::new(),
            FilesOf::Host(files) => files.missing(&self.document, &self.registry),
        }
    }

    /// Keeps the bytes of a file that was missing, or why there are none. Earlier clones are as they were.
    pub fn insert(&mut self, path: String, bytes: Result<Arc<[u8]>, String>) {
        if let FilesOf::Host(files) = &mut self.files {
            Arc::make_mut(files).insert(path, bytes);
        }
    }

    /// `true` if both are of one moment.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.document, &other.document)
    }

    /// The graph at a tier. Warnings are logged.
    pub(crate) fn graph(&self, tier: Option<&str>) -> Result<Graph, Error> {
        let (graph, warnings) = self.check(tier, &[])?;
        if !warnings.is_empty() {
            log::warn!("{warnings}");
        }
        Ok(graph)
    }

    /// The graph at a tier with changed parameters, and the warnings: [`Checker::check`].
    ///
    /// # Errors
    /// The pipeline or a file that it names is wrong; there is no such tier.
    pub fn check(&self, tier: Option<&str>, sets: &[(String, String)]) -> Result<(Graph, Diagnostics), Error> {
        Ok(self.checker().check(tier, sets)?)
    }

    /// The names of the tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        self.checker().tiers()
    }

    /// The claim of the pipeline's own file for a tier: its time and its error, and what they were measured on. `None`
    /// where it claims nothing.
    pub fn claim(&self, tier: &str) -> Option<&Claim> {
        self.document.claims.iter().find(|(name, _)| name.value == tier).map(|(_, claim)| claim)
    }

    /// A governor of tiers with what the pipeline claims of them. There is at least one.
    pub(crate) fn governor(&self, limits: TierLimits, tiers: &[&str]) -> Governor {
        let of = |tier: &&str| {
            let claim = self.claim(tier);
            let seen = claim.filter(|claim| limits.display.is_none() || claim.display == limits.display);
            let (cost, jod) = (claim.and_then(|claim| claim.ms), seen.and_then(|claim| claim.jod));
            GovernedTier { name: (*tier).to_owned(), cost, jod }
        };
        let tiers: Vec<GovernedTier> = tiers.iter().map(of).collect();
        Governor::new(limits, &tiers)
    }

    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(crate) fn registry(&self) -> &Registry {
        &self.registry
    }

    fn checker(&self) -> Checker<'_> {
        let files: &dyn Loader = match &self.files {
            FilesOf::Disk(files) => &**files,
            FilesOf::Host(files) => &**files,
        };
        Checker::new(&self.document, &self.registry, files)
    }
}

/// The files that a source may name.
pub(crate) fn files_of(source: &Source) -> Arc<Files> {
    Files::new(folder_of(source), &source.allowed, &source.kind_folders).into()
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
        let message = format!("there is no pipeline `{}`\n  hint: {}", shown_path(path), built_in_hint());
        return Err(Error::Unreadable(message));
    }
    files.pipeline(path)
}
