//! Pipeline files as assets, with all files that they name.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_base::diagnostic::Diagnostics;
use afterimage_graph::check::{CheckOptions, Graph, Loader, check};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::{DuplicateKind, NodeKind, Registry, folder_kind_of};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

/// A pipeline file, its files, and the kinds that it may use.
#[derive(Asset, TypePath)]
pub struct Pipeline {
    document: Document,
    kinds: Registry,
    files: BTreeMap<String, Bytes>,
}

/// The bytes of a file, or why there are none.
type Bytes = Result<Arc<[u8]>, String>;

/// Why a pipeline is not loaded.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// A file is wrong: the messages, with excerpts.
    #[error("\n{0}")]
    Wrong(String),
    /// Two kinds have one name.
    #[error(transparent)]
    Kinds(#[from] DuplicateKind),
}

impl From<Diagnostics> for PipelineError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Wrong(diagnostics.to_string())
    }
}

/// Loads pipelines from `.ron` files.
#[derive(Default, TypePath)]
pub struct PipelineLoader {
    /// Tables of kinds beside the built-in ones.
    pub kinds: Vec<&'static [NodeKind]>,
    /// Folders of assets with a `node.ron` and shaders.
    pub node_folders: Vec<String>,
}

impl AssetLoader for PipelineLoader {
    type Asset = Pipeline;
    type Settings = ();
    type Error = PipelineError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<Pipeline, PipelineError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await.map_err(|error| PipelineError::Unreadable(error.to_string()))?;
        let name = context.path().to_string();
        let document = parse(&name, &text(&name, bytes)?)?;
        let mut pipeline = Pipeline { document, kinds: self.registry(context).await?, files: BTreeMap::new() };
        let tiers: Vec<String> = pipeline.document.tiers.iter().map(|(name, _)| name.value.clone()).collect();
        for tier in std::iter::once(None).chain(tiers.into_iter().map(Some)) {
            pipeline.read_files(tier.as_deref(), context).await;
            pipeline.graph(tier.as_deref())?;
        }
        Ok(pipeline)
    }

    fn extensions(&self) -> &[&str] {
        &["ron"]
    }
}

impl PipelineLoader {
    async fn registry(&self, context: &mut LoadContext<'_>) -> Result<Registry, PipelineError> {
        let mut folder_kinds = Vec::new();
        for folder in &self.node_folders {
            let name = folder.rsplit('/').next().unwrap_or(folder);
            let [node, shader] = [format!("{folder}/node.ron"), format!("{folder}/{name}.wgsl")];
            let mut texts = Vec::new();
            for file in [&node, &shader] {
                let bytes = context.read_asset_bytes(file.clone()).await;
                texts.push(text(file, bytes.map_err(|error| PipelineError::Unreadable(error.to_string()))?)?);
            }
            folder_kinds.push(folder_kind_of((&node, &texts[0]), &[(&shader, &texts[1])])?);
        }
        let tables: Vec<&[NodeKind]> =
            [afterimage_nodes::ALL, &folder_kinds].into_iter().chain(self.kinds.iter().copied()).collect();
        Ok(Registry::new(&tables)?)
    }
}

fn text(file: &str, bytes: Vec<u8>) -> Result<String, PipelineError> {
    String::from_utf8(bytes).map_err(|_| PipelineError::Unreadable(format!("{file} is no text")))
}

/// The files that are there, and the names of those that were asked for and are not.
struct Files<'a> {
    known: &'a BTreeMap<String, Bytes>,
    missing: RefCell<Vec<String>>,
}

impl Loader for Files<'_> {
    fn load(&self, path: &str) -> Bytes {
        self.known.get(path).cloned().unwrap_or_else(|| {
            self.missing.borrow_mut().push(path.to_owned());
            Err("it is not loaded".into())
        })
    }
}

impl Pipeline {
    /// Reads what a tier needs: the check asks for files, and those may name others.
    async fn read_files(&mut self, tier: Option<&str>, context: &mut LoadContext<'_>) {
        loop {
            let missing = {
                let files = Files { known: &self.files, missing: RefCell::default() };
                // Its errors are reported once all files are there.
                let _ = self.check(tier, &files);
                files.missing.into_inner()
            };
            if missing.is_empty() {
                return;
            }
            for path in missing {
                let bytes = context.read_asset_bytes(path.clone()).await;
                self.files.insert(path, bytes.map(Arc::from).map_err(|error| error.to_string()));
            }
        }
    }

    fn check(&self, tier: Option<&str>, loader: &dyn Loader) -> Result<Graph, Diagnostics> {
        let options = CheckOptions { tier: tier.map(str::to_owned), sets: Vec::new(), loader };
        Ok(check(&self.document, &self.kinds, &options)?.0)
    }

    /// The graph at a tier.
    ///
    /// # Errors
    /// What is wrong with the file or with those that it names.
    pub fn graph(&self, tier: Option<&str>) -> Result<Graph, Diagnostics> {
        self.check(tier, &Files { known: &self.files, missing: RefCell::default() })
    }

    /// The names of its tiers.
    pub fn tiers(&self) -> impl Iterator<Item = &str> {
        self.document.tiers.iter().map(|(name, _)| name.value.as_str())
    }
}
