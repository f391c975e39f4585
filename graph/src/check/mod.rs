//! Checking: a document becomes a graph that makes sense, or all of its mistakes are told at once.
//!
//! [`check`] reads as the list of its steps: inherit (`extends`, the tier), expand (node kinds, parameters, pipelines used as nodes), change
//! (`set`, tiers, `--set`), connect (wires to their sources), agree (port types, image states), order (no circles), and look for what
//! nobody needs. A [`Graph`] that comes out is valid by construction: every wire has two ends of one type, every value is in its domain,
//! and nothing waits for itself.

mod agree;
mod build;
pub mod condition;
mod connect;
mod expand;
mod files;
mod graph;
mod order;
mod settings;
mod suggest;
mod unneeded;
mod values;
mod verify;

use std::sync::Arc;

use crate::document::Document;
use crate::node::Registry;
use afterimage_base::diagnostic::Diagnostics;

pub use condition::{Condition, ConditionError, Fact, FactKind, Facts};
pub use graph::{Graph, GraphInput, GraphNode, GraphOutput, Source};

use build::Builder;

/// Reads files for the check, which does no input or output of its own.
pub trait Loader {
    /// The bytes of a file, or why there are none. Paths are relative to the file that names them, already joined to its folder.
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String>;
}

/// A loader for hosts without files: every path is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Loader for NoFiles {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Err("this program gives pipelines no access to files".into())
    }
}

/// What a check may be told beside the document.
#[derive(Clone)]
pub struct CheckOptions<'a> {
    /// The quality level, one of the document's `tiers`.
    pub tier: Option<String>,
    /// Changes in the order in which they are made: `node.parameter` and a value as a pipeline file would write it.
    pub sets: Vec<(String, String)>,
    /// Where files come from.
    pub loader: &'a dyn Loader,
}

impl Default for CheckOptions<'_> {
    fn default() -> Self {
        Self { tier: None, sets: Vec::new(), loader: &NoFiles }
    }
}

/// More nodes than this, pipelines used as nodes and what is in them included, are a mistake.
pub const MOST_NODES: usize = 1 << 16;
/// Frames that a wire can reach back.
pub const MOST_PREVIOUS: u32 = 16;
/// Pipelines within pipelines, and files that extend files.
pub const DEEPEST: usize = 16;

/// Makes a graph of a document.
///
/// The warnings come beside the graph. Every tier's changes are checked, whether or not the tier is asked for; only the asked one is made.
///
/// # Errors
/// All mistakes of the document and of the files that it names, and the warnings with them, in the order of their places.
pub fn check(
    document: &Document,
    registry: &Registry,
    options: &CheckOptions<'_>,
) -> Result<(Graph, Diagnostics), Diagnostics> {
    let mut builder = Builder::new(registry, options.loader, document.problems.clone());
    let document = builder.inherited(document);
    let document = builder.tier(document, options.tier.as_deref());
    builder.expand_top(&document);
    builder.command_line(&options.sets);
    builder.change();
    builder.verify();
    builder.connect();
    builder.agree();
    builder.order();
    builder.tell_unneeded();
    builder.finish()
}
