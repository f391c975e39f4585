//! Files of assets that pipelines and node folders name, and why they are not loaded.

use afterimage_base::diagnostic::Diagnostics;
use afterimage_graph::node::RegistryError;
use bevy::asset::{AssetPath, LoadContext};

/// Why a pipeline is not loaded.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// A file is wrong. Written, each message has its excerpt.
    #[error("\n{0}")]
    Wrong(Diagnostics),
    /// Two kinds have one name, or a shader of one is wrong.
    #[error(transparent)]
    Kinds(#[from] RegistryError),
}

impl From<Diagnostics> for PipelineError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Wrong(diagnostics)
    }
}

/// The bytes of a file that another one names. A name that leaves the folder of assets is refused, as Bevy refuses it
/// for assets, and one that is no path of assets is an error and no panic.
pub(crate) async fn read_bytes(path: &str, context: &mut LoadContext<'_>) -> Result<Vec<u8>, String> {
    let path = AssetPath::try_parse(path).map_err(|error| error.to_string())?;
    if path.is_unapproved() {
        return Err("it is not in the folder of assets".into());
    }
    context.read_asset_bytes(path).await.map_err(|error| error.to_string())
}

/// The text of a file.
pub(crate) fn text(file: &str, bytes: Vec<u8>) -> Result<String, PipelineError> {
    String::from_utf8(bytes).map_err(|_| PipelineError::Unreadable(format!("{file} is no text")))
}
