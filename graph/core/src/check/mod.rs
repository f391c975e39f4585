//! Checking: a document becomes a valid graph, or all of its errors are reported.
//!
//! [`Checker::check`] lists the steps: inherit (`extends`, the tier), expand (node kinds, parameters, pipelines used
//! as nodes), apply overrides (`set`, tiers, `--set`), connect (wires to their sources), agree (port types, color
//! states), order (no cycles), and warn of unneeded nodes. A [`Graph`] is valid by construction: both ends of every
//! wire have one type, every value is in its domain, and no node waits for itself.
//!
//! # Several tiers
//!
//! A [`Checker`] parses each file once, however many tiers and overrides are checked:
//!
//! ```
//! use afterimage_graph::check::{Checker, NoFiles};
//! # let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
//! let text = r#"Pipeline(
//!     inputs: { "scene": Color },
//!     nodes: { "exposed": Exposure(source: "scene", stops: 1.0) },
//!     outputs: { "display": "exposed" },
//!     tiers: { "dark": { "exposed.stops": -2.0 } },
//! )"#;
//! let document = afterimage_graph::document::parse("look.ron", text)?;
//! let checker = Checker::new(&document, &registry, &NoFiles);
//! let (as_written, _warnings) = checker.check(None, &[])?;
//! for tier in checker.tiers() {
//!     let (graph, _warnings) = checker.check(Some(&tier), &[])?;
//!     assert_eq!(graph.nodes.len(), as_written.nodes.len());
//! }
//! # Ok::<(), afterimage_graph::diagnostic::Diagnostics>(())
//! ```

mod agree;
mod bounds;
mod colors;
pub mod condition;
mod connect;
mod coverage;
mod displays;
mod draft;
mod expand;
mod fields;
mod files;
mod graph;
mod inherit;
pub mod limits;
mod loaded_files;
mod mixes;
mod named_files;
mod nodes;
mod options;
mod order;
mod parameters;
mod reports;
mod save;
mod settings;
mod suggest;
mod tier;
mod unneeded;

use crate::document::Document;
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics};

pub use colors::ImageColors;
pub use condition::{Condition, ConditionError, Fact, FactKind, Facts};
pub use fields::NODE_FIELDS;
pub use graph::{Graph, GraphInput, GraphNode, GraphOutput, ParameterId, Source};
pub use loaded_files::LoadedFiles;
pub use options::{CheckOptions, Loader, NoFiles};
pub use save::{Candidate, Change, Connection, Edit, Reader, Saver};
pub use suggest::kinds_about;

use agree::Agreement;
use connect::Connector;
use expand::Expansion;
use fields::FieldReader;
use files::Files;
use inherit::UsedFiles;
use reports::Reports;

/// Checks a document at its tiers and with overrides. Every file that it names is read and parsed once.
pub struct Checker<'a> {
    document: &'a Document,
    registry: &'a Registry,
    files: Files<'a>,
}

impl<'a> Checker<'a> {
    /// A checker that reads files with `loader`.
    pub fn new(document: &'a Document, registry: &'a Registry, loader: &'a dyn Loader) -> Self {
        Self { document, registry, files: Files::new(loader) }
    }

    /// The names of the document's tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        let document = UsedFiles::new(&self.files).inherited(self.document, &mut Reports::default());
        document.tiers.into_iter().map(|(name, _)| name.value).collect()
    }

    /// The names of the facts that the document declares, with their meanings, inherited ones first.
    pub fn facts(&self) -> Vec<(String, String)> {
        let document = UsedFiles::new(&self.files).inherited(self.document, &mut Reports::default());
        document.facts.into_iter().flatten().map(|(name, meaning)| (name.value, meaning)).collect()
    }

    /// The names of the parameters that people change first, with their meanings, inherited ones first.
    pub fn usual(&self) -> Vec<(String, String)> {
        let document = UsedFiles::new(&self.files).inherited(self.document, &mut Reports::default());
        document.usual.into_iter().map(|(name, meaning)| (name.value, meaning.value)).collect()
    }

    /// Makes a graph of the document at a tier, with overrides in the order in which they are applied: `node.parameter`
    /// and a value as a pipeline file would write it.
    ///
    /// Returns the graph and the warnings. The overrides of every tier are checked; only those of `tier` are applied.
    ///
    /// # Errors
    /// All errors of the document and of the files that it names, and the warnings with them, ordered by location.
    pub fn check(&self, tier: Option<&str>, sets: &[(String, String)]) -> Result<(Graph, Diagnostics), Diagnostics> {
        check_with(self.document, self.registry, &self.files, (tier, sets))
    }
}

/// Makes a graph of a document at a tier, with overrides: see [`Checker::check`].
fn check_with(
    document: &Document,
    registry: &Registry,
    files: &Files<'_>,
    (tier, sets): (Option<&str>, &[(String, String)]),
) -> Result<(Graph, Diagnostics), Diagnostics> {
    let mut expansion = Expansion::new(registry, files, document.problems.clone());
    let document = expansion.fields.inherited(document);
    expansion.check_claims(&document);
    let document = expansion.tier(document, tier);
    expansion.expand_top(&document);
    expansion.command_line(sets);
    expansion.change();
    let Expansion { mut drafted, fields: FieldReader { mut reports, .. }, .. } = expansion;
    drafted.report_long_conditions(&mut reports);
    let instances = drafted.instances(&mut reports);
    Connector { drafted: &mut drafted, reports: &mut reports }.connect();
    drafted.find_states();
    Agreement { registry, drafted: &drafted, reports: &mut reports }.agree();
    drafted.order(&mut reports);
    drafted.report_unneeded(&mut reports);
    if reports.diagnostics.has_errors() {
        return Err(reports.diagnostics.sorted());
    }
    let graph = drafted.graph(registry, instances);
    report_unknown_usual(&graph, &document, &mut reports);
    drafted.agree_on_colors(&graph, &mut reports);
    drafted.agree_on_displays(&graph, &mut reports);
    drafted.report_covered_curves(&graph, &mut reports);
    let diagnostics = reports.diagnostics.sorted();
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((graph, diagnostics)) }
}

/// Reports usual parameters that the graph does not have. An inherited one may be of a node that was replaced.
fn report_unknown_usual(graph: &Graph, document: &Document, reports: &mut Reports) {
    for (name, _) in document.usual.iter().filter(|(name, _)| name.location.file == document.file) {
        if let Err(message) = graph.parameter(&name.value) {
            reports.push(Diagnostic::error("unknown-name", message).at(&name.location, ""));
        }
    }
}

/// Makes a graph of a document: [`Checker::check`] for a single check.
///
/// # Errors
/// All errors of the document and of the files that it names, and the warnings with them, ordered by location.
pub fn check(
    document: &Document,
    registry: &Registry,
    options: &CheckOptions<'_>,
) -> Result<(Graph, Diagnostics), Diagnostics> {
    Checker::new(document, registry, options.loader).check(options.tier.as_deref(), &options.sets)
}
