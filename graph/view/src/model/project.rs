//! Where the viewer's pipeline comes from.

use std::sync::Arc;

use afterimage_graph::check::{Change, Checker, Graph, Loader, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::{Claim, parse};
use afterimage_graph::node::Registry;
use afterimage_pipelines::BuiltIn;

/// Where the text of a pipeline, and the files that it names, are read and written.
pub trait Project {
    /// Its name for people, such as `tsushima.ron`.
    fn name(&self) -> String;

    /// Reads its text from where it is stored.
    ///
    /// # Errors
    /// It cannot be read.
    fn read(&mut self) -> Result<String, Diagnostics>;

    /// Checks a text of it, for a tier.
    ///
    /// # Errors
    /// What is wrong with the text, or with a file that it names.
    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics>;

    /// Whether the stored text, or a file that the last [`check`](Self::check) has read, is different now.
    fn has_changed(&mut self) -> bool;

    /// The text with changed values in it; everything else stays as it is. `new_tier` puts them into a tier of that
    /// name.
    ///
    /// # Errors
    /// Why they cannot be written.
    fn saved(
        &self,
        text: &str,
        tier: Option<&str>,
        new_tier: Option<&str>,
        changes: &[Change],
    ) -> Result<String, Diagnostics>;

    /// The bytes of a file that the pipeline may name.
    ///
    /// # Errors
    /// Why there are none, for people.
    fn file(&self, path: &str) -> Result<Arc<[u8]>, String>;

    /// Writes a text to where the pipeline comes from.
    ///
    /// # Errors
    /// Why it cannot be written, for people.
    fn write(&mut self, text: &str) -> Result<(), String>;
}

/// What a check has found.
pub struct Checked {
    pub graph: Graph,
    pub warnings: Diagnostics,
    /// The tiers of the pipeline.
    pub tiers: Vec<String>,
    /// What the text claims of tiers.
    pub claims: Vec<(String, Claim)>,
    /// The facts that the pipeline declares, with their meanings.
    pub facts: Vec<(String, String)>,
}

impl Checked {
    /// Checks a text whose files `loader` reads.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn of(
        name: &str,
        text: &str,
        tier: Option<&str>,
        registry: &Registry,
        loader: &dyn Loader,
    ) -> Result<Self, Diagnostics> {
        let document = parse(name, text)?;
        let checker = Checker::new(&document, registry, loader);
        let (graph, warnings) = checker.check(tier, &[])?;
        let claims = document.claims.iter().map(|(tier, claim)| (tier.value.clone(), claim.clone())).collect();
        Ok(Self { graph, warnings, tiers: checker.tiers(), claims, facts: checker.facts() })
    }
}

/// The text of a pipeline with changes in it: see [`Project::saved`].
///
/// # Errors
/// Why they cannot be written.
pub fn saved(
    saver: &Saver<'_>,
    tier: Option<&str>,
    new_tier: Option<&str>,
    changes: &[Change],
) -> Result<String, Diagnostics> {
    match new_tier {
        None => saver.save(tier, changes),
        Some(new) => saver.save_as_tier(new, tier, changes),
    }
}

/// A pipeline that lies in memory: a built-in one, or a text that was pasted. What is written stays in memory.
pub struct TextProject {
    name: String,
    written: String,
    registry: Registry,
}

impl TextProject {
    /// A pipeline of that name. It may use the built-in kinds, and name the built-in files.
    ///
    /// # Panics
    /// If two built-in kinds had one name.
    pub fn new(name: &str, text: &str) -> Self {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("built-in kinds have different names");
        Self::with_registry(name, text, registry)
    }

    /// A pipeline of that name with kinds of its own. It may name the built-in files.
    pub fn with_registry(name: &str, text: &str, registry: Registry) -> Self {
        Self { name: name.to_owned(), written: text.to_owned(), registry }
    }

    /// The built-in pipeline of that name, such as `lynx`.
    pub fn built_in(name: &str) -> Option<Self> {
        let (_, text) = afterimage_pipelines::PIPELINES.iter().find(|(known, _)| *known == name)?;
        Some(Self::new(&format!("{name}.ron"), text))
    }
}

impl Project for TextProject {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn read(&mut self) -> Result<String, Diagnostics> {
        Ok(self.written.clone())
    }

    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        Checked::of(&self.name, text, tier, &self.registry, &BuiltIn)
    }

    fn has_changed(&mut self) -> bool {
        false
    }

    fn saved(
        &self,
        text: &str,
        tier: Option<&str>,
        new_tier: Option<&str>,
        changes: &[Change],
    ) -> Result<String, Diagnostics> {
        saved(&Saver::new(&self.name, text, &self.registry, &BuiltIn)?, tier, new_tier, changes)
    }

    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        BuiltIn.load(path)
    }

    fn write(&mut self, text: &str) -> Result<(), String> {
        self.written = text.to_owned();
        Ok(())
    }
}
