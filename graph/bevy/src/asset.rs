//! Pipeline files as assets, with all files that they name.

use std::sync::Arc;

use afterimage_base::diagnostic::Diagnostics;
use afterimage_graph::check::{Checker, Graph, LoadedFiles};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::{NodeKind, Registry, folder_kind};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::files::{PipelineError, read_bytes, text};
use crate::folder;

/// A pipeline file, its files, and the kinds that it may use.
#[derive(Asset, TypePath)]
#[type_path = "bevy_afterimage"]
pub struct Pipeline {
    document: Document,
    kinds: Registry,
    files: LoadedFiles,
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
        let (name, mut bytes) = (context.path().to_string(), Vec::new());
        let result = reader.read_to_end(&mut bytes).await;
        result.map_err(|error| PipelineError::Unreadable(format!("{name}: {error}")))?;
        // The folders come first: a pipeline that is wrong is read again when one of them changes.
        let kinds = self.registry(context).await?;
        let document = parse(&name, &text(&name, bytes)?)?;
        let mut pipeline = Pipeline { document, kinds, files: LoadedFiles::default() };
        loop {
            let missing = pipeline.files.missing(&pipeline.document, &pipeline.kinds);
            if missing.is_empty() {
                break;
            }
            for path in missing {
                let bytes = read_bytes(&path, context).await;
                pipeline.files.insert(path, bytes.map(Arc::from));
            }
        }
        let (_, warnings) = pipeline.check(None)?;
        if !warnings.is_empty() {
            warn!("\n{warnings}");
        }
        for tier in pipeline.tiers() {
            pipeline.graph(Some(&tier))?;
        }
        Ok(pipeline)
    }

    fn extensions(&self) -> &[&str] {
        &["ron"]
    }
}

impl PipelineLoader {
    async fn registry(&self, context: &mut LoadContext<'_>) -> Result<Registry, PipelineError> {
        let mut folder_kinds = vec![folder_kind(
            ("prepass_normals/node.ron", include_str!("prepass_normals/node.ron")),
            ("prepass_normals/prepass_normals.wgsl", include_str!("prepass_normals/prepass_normals.wgsl")),
        )?];
        for folder in &self.node_folders {
            folder_kinds.push(folder::kind(folder, context).await?);
        }
        let tables: Vec<&[NodeKind]> =
            [afterimage_nodes::ALL, &folder_kinds].into_iter().chain(self.kinds.iter().copied()).collect();
        Ok(Registry::new(&tables)?)
    }
}

impl Pipeline {
    fn check(&self, tier: Option<&str>) -> Result<(Graph, Diagnostics), Diagnostics> {
        Checker::new(&self.document, &self.kinds, &self.files).check(tier, &[])
    }

    /// The graph at a tier: its parameters with their domains, its facts, its nodes.
    ///
    /// # Errors
    /// What is wrong with the file or with those that it names.
    pub fn graph(&self, tier: Option<&str>) -> Result<Graph, Diagnostics> {
        Ok(self.check(tier)?.0)
    }

    /// The names of its tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        Checker::new(&self.document, &self.kinds, &self.files).tiers()
    }
}
