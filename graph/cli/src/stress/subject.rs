//! What is put under stress: a pipeline, or a kind on its own.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, PortType, Registry};

use super::wiring::{NODE, Wires, alone};
use crate::pipeline::Files;
use crate::shipped::Shipped;

/// Changes of parameters: `node.parameter` and its value, as `--set` takes them.
pub(crate) type Sets = Vec<(String, String)>;

/// A pipeline or a kind.
#[derive(Clone, Debug)]
pub struct Subject {
    /// What reports call it.
    pub title: String,
    /// The words after `afterimage stress` that choose it.
    pub(crate) words: String,
    file: String,
    text: String,
    /// The text in which no identity leaves the node out; for kinds with image outputs.
    forced: Option<String>,
    tier: Option<String>,
    /// Whether the files that it names come with the program.
    is_shipped: bool,
    /// Whether it is one kind.
    pub(crate) is_kind: bool,
    /// Whether it is a kind whose main output is a value.
    pub(crate) shows_value: bool,
    /// Whether optional inputs stay without an image.
    pub(crate) bare: bool,
    /// Whether light may be negative: only images with negative numbers are run.
    pub(crate) signed: bool,
    /// Whether its parameters are swept over their domains.
    pub(crate) sweep: bool,
    /// Changes that are always made.
    pub(crate) base: Sets,
    pub(crate) facts: Facts,
}

/// The file that kinds with a file parameter are given: a table of two nodes a side that swaps and bends the channels.
const CUBE: &str = "stress.cube";
const CUBE_TEXT: &str = "LUT_3D_SIZE 2\n0 0.1 0\n0.9 0 0.1\n0 0 0.8\n1 0.2 1\n0.1 1 0\n0.8 1 0.3\n0 0.9 1\n1 1 1\n";

struct StressFiles;

impl Loader for StressFiles {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        if path == CUBE { Ok(CUBE_TEXT.as_bytes().into()) } else { Files.load(path) }
    }
}

impl Subject {
    /// A pipeline from its text; `words` choose it on the command line.
    pub fn pipeline(title: &str, file: &str, text: &str, tier: Option<&str>) -> Self {
        let flag = tier.map_or(String::new(), |tier| format!(" --tier {tier}"));
        Self {
            title: format!("{title}{}", tier.map_or(String::new(), |tier| format!(" ({tier})"))),
            words: format!("{file}{flag}"),
            file: file.to_owned(),
            text: text.to_owned(),
            forced: None,
            tier: tier.map(str::to_owned),
            is_shipped: false,
            is_kind: false,
            shows_value: false,
            bare: false,
            signed: false,
            sweep: tier.is_none(),
            base: Sets::new(),
            facts: Facts::default(),
        }
    }

    /// A pipeline that comes with the program.
    pub(crate) fn shipped(name: &str, text: &str, tier: Option<&str>) -> Self {
        let file = format!("{name}.ron");
        Self { is_shipped: true, file, ..Self::pipeline(name, &format!("pipelines/{name}.ron"), text, tier) }
    }

    /// A kind on its own, with its optional inputs, or `bare` without; `signed` light may be negative. `None` where nothing makes what
    /// the kind needs, or shows what it gives.
    pub fn kind(registry: &Registry, kind: &NodeKind, bare: bool, signed: bool) -> Option<Self> {
        let name = kind.name();
        let (title, flag) = match (bare, signed) {
            (false, false) => ("", ""),
            (true, false) => (" (bare)", " --bare"),
            (false, true) => (" (signed)", " --signed"),
            (true, true) => (" (bare, signed)", " --bare --signed"),
        };
        let wires = Wires { bare, signed, forced: false, file: CUBE };
        Some(Self {
            title: format!("{name}{title}"),
            words: format!("--kind {name}{flag}"),
            file: format!("{name}.ron"),
            text: alone(registry, kind, wires)?,
            forced: alone(registry, kind, Wires { forced: true, ..wires }),
            tier: None,
            is_shipped: false,
            is_kind: true,
            shows_value: kind.output(kind.main_output()).is_some_and(|output| output.ty == PortType::Value),
            bare,
            signed,
            sweep: true,
            base: Sets::new(),
            facts: Facts::default(),
        })
    }

    /// Whether anything is given to it.
    pub(crate) fn takes_pictures(&self) -> bool {
        self.text.contains("allow_negative")
    }

    /// The pipeline without images for its optional inputs.
    pub(crate) fn without_optional(&self) -> Self {
        let (title, words) = (format!("{} (bare)", self.title), format!("{} --bare", self.words));
        Self { title, words, bare: true, sweep: false, ..self.clone() }
    }

    /// The same, chosen by more words.
    pub(crate) fn with_words(&self, more: &str) -> Self {
        Self { words: format!("{}{more}", self.words), ..self.clone() }
    }

    /// The graph with these changes; what is wrong with them otherwise.
    pub(crate) fn graph(&self, registry: &Registry, sets: &Sets) -> Result<Graph, Diagnostics> {
        self.checked(&self.text, registry, sets)
    }

    /// The graph in which the kind always runs.
    pub(crate) fn forced(&self, registry: &Registry, sets: &Sets) -> Option<Graph> {
        self.checked(self.forced.as_ref()?, registry, sets).ok()
    }

    fn checked(&self, text: &str, registry: &Registry, sets: &Sets) -> Result<Graph, Diagnostics> {
        let sets = self.base.iter().chain(sets).cloned().collect();
        let loader: &dyn Loader = if self.is_shipped { &Shipped } else { &StressFiles };
        let options = CheckOptions { tier: self.tier.clone(), sets, loader };
        Ok(check(&parse(&self.file, text)?, registry, &options)?.0)
    }

    /// Whether the parameters of a node are swept.
    pub(crate) fn sweeps(&self, node: &str) -> bool {
        !self.is_kind || node == NODE
    }
}
