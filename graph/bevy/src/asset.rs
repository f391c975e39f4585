//! Pipeline files as assets, with all files that they name.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage::Error;
use afterimage::host::{Claim, Graph, NodeKind, PIPELINES, Snapshot, TABLES};
use afterimage::node::folder_kind;
use bevy::asset::io::Reader;
use bevy::asset::io::embedded::EmbeddedAssetRegistry;
use bevy::asset::{AssetLoader, AssetPath, LoadContext};
use bevy::prelude::*;

use crate::folder;

/// A pipeline file, its files, and the kinds that it may use. Clones share them.
#[derive(Asset, Clone, TypePath)]
#[type_path = "bevy_afterimage"]
pub struct Pipeline {
    pub(crate) snapshot: Snapshot,
    /// The file as it is written: inputs and outputs are those of all tiers.
    pub(crate) written: Arc<Graph>,
    tiers: Vec<String>,
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
    type Error = Error;

    async fn load(&self, reader: &mut dyn Reader, _: &(), context: &mut LoadContext<'_>) -> Result<Pipeline, Error> {
        // Without the name of the source: what the file names is of the same source.
        let (name, mut bytes) = (context.path().path().to_string_lossy().into_owned(), Vec::new());
        let result = reader.read_to_end(&mut bytes).await;
        result.map_err(|error| Error::Unreadable(format!("{name}: {error}")))?;
        // The folders come first: a pipeline that is wrong is read again when one of them changes.
        let kinds = self.kinds(context).await?;
        let mut snapshot = Snapshot::of_text(&name, &text(&name, bytes)?, &kinds)?;
        loop {
            let missing = snapshot.missing();
            if missing.is_empty() {
                break;
            }
            for path in missing {
                let source = context.path().source().clone_owned();
                let bytes = match AssetPath::try_parse(&path) {
                    Ok(parsed) => read_bytes(parsed.with_source(source), context).await,
                    Err(error) => Err(error.to_string()),
                };
                snapshot.insert(path, bytes.map(Arc::from));
            }
        }
        let (written, tiers) = (snapshot.check(None, &[])?.0.into(), snapshot.tiers());
        for tier in &tiers {
            snapshot.check(Some(tier), &[])?;
        }
        Ok(Pipeline { snapshot, written, tiers })
    }

    fn extensions(&self) -> &[&str] {
        &["ron"]
    }
}

impl PipelineLoader {
    async fn kinds(&self, context: &mut LoadContext<'_>) -> Result<Vec<NodeKind>, Error> {
        let mut kinds = vec![folder_kind(
            ("prepass_normals/node.ron", include_str!("prepass_normals/node.ron")),
            ("prepass_normals/prepass_normals.wgsl", include_str!("prepass_normals/prepass_normals.wgsl")),
        )?];
        for folder in &self.node_folders {
            kinds.push(folder::kind(folder, context).await?);
        }
        self.kinds.iter().for_each(|table| kinds.extend_from_slice(table));
        Ok(kinds)
    }
}

impl Pipeline {
    /// The graph at a tier: its parameters with their domains, its facts, its nodes.
    ///
    /// # Errors
    /// There is no such tier.
    pub fn graph(&self, tier: Option<&str>) -> Result<Graph, Error> {
        Ok(self.snapshot.check(tier, &[])?.0)
    }

    /// Its claim for a tier: time and error, and the conditions of the measurement.
    pub fn claim(&self, tier: &str) -> Option<&Claim> {
        self.snapshot.claim(tier)
    }

    /// The names of its tiers, inherited ones first.
    pub fn tiers(&self) -> &[String] {
        &self.tiers
    }
}

/// The built-in pipelines as assets: `embedded://afterimage/tsushima.ron`.
pub(crate) fn embed(registry: &EmbeddedAssetRegistry) {
    let pipelines = PIPELINES.iter().map(|(name, text)| (format!("{name}.ron"), text.as_bytes()));
    for (file, bytes) in pipelines.chain(TABLES.iter().map(|(path, bytes)| ((*path).to_owned(), *bytes))) {
        registry.insert_asset(PathBuf::new(), &Path::new("afterimage").join(file), bytes);
    }
}

/// The bytes of a file that another one names. A name that leaves the folder of assets is refused, as Bevy refuses it
/// for assets.
pub(crate) async fn read_bytes(path: AssetPath<'_>, context: &mut LoadContext<'_>) -> Result<Vec<u8>, String> {
    if path.is_unapproved() {
        return Err("it is not in the folder of assets".into());
    }
    context.read_asset_bytes(path).await.map_err(|error| error.to_string())
}

/// The text of a file.
pub(crate) fn text(file: &str, bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|_| Error::Unreadable(format!("{file} is no text")))
}
