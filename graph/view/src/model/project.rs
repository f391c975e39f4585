//! Storage of the viewer's pipeline.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use afterimage_graph::check::{Checker, Graph, Loader, Saver, Source};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::{Claim, parse};
use afterimage_graph::image::ColorState;
use afterimage_graph::node::{PortType, Registry};
use afterimage_pipelines::BuiltIn;

/// Storage of the text of a pipeline, and of the files that it names.
pub trait Project {
    /// Its name for people, such as `tsushima.ron`.
    fn name(&self) -> String;

    /// Reads its text from where it is stored; `None` if nothing is there.
    ///
    /// # Errors
    /// Something is there, and cannot be read.
    fn read(&mut self) -> Result<Option<String>, Diagnostics>;

    /// Checks a text of it, for a tier.
    ///
    /// # Errors
    /// All errors in the text, or in a file that it names.
    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics>;

    /// True if the stored text, or a file that the last [`check`](Self::check) has read, is different now.
    fn has_changed(&mut self) -> bool;

    /// Calls back once with what writes changes and edits into a text of it.
    ///
    /// # Errors
    /// The text has syntax errors, or the kinds cannot be read. Nothing is called then.
    fn with_saver(&self, text: &str, ask: &mut dyn FnMut(&Saver<'_>)) -> Result<(), Diagnostics>;

    /// The bytes of a file that the pipeline may name.
    ///
    /// # Errors
    /// The reason why it cannot be read, for people.
    fn file(&self, path: &str) -> Result<Arc<[u8]>, String>;

    /// True if it has a place for [`write`](Self::write). A built-in pipeline has none.
    fn has_place(&self) -> bool;

    /// The file in which it is, by which it can be opened again.
    fn path(&self) -> Option<&Path> {
        None
    }

    /// Writes a text to the place of the pipeline, and returns that place, for people.
    ///
    /// # Errors
    /// The reason why it cannot be written, for people.
    fn write(&mut self, text: &str) -> Result<String, String>;

    /// The files that a text of it names and that are in memory alone: their paths beside it, and their bytes.
    fn files_in_memory(&self, _text: &str) -> Vec<NamedFile> {
        Vec::new()
    }
}

/// A path as a pipeline names it, and the bytes of the file.
pub type NamedFile = (String, Arc<[u8]>);

/// Stores a text under the name of its pipeline, and returns where, for people.
pub type Store = Box<dyn Fn(&str, &str) -> Result<String, String>>;

/// The result of a check without errors.
pub struct Checked {
    pub graph: Arc<Graph>,
    pub warnings: Diagnostics,
    /// The tiers of the pipeline.
    pub tiers: Vec<String>,
    /// The measurements of tiers that the text states.
    pub claims: Vec<(String, Claim)>,
    /// The facts that the pipeline declares, with their meanings.
    pub facts: Vec<(String, String)>,
    /// The parameters that people change first, with their meanings.
    pub usual: Vec<(String, String)>,
}

impl Checked {
    /// Checks a text whose files `loader` reads.
    ///
    /// # Errors
    /// All errors in it.
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
        let (tiers, facts, usual) = (checker.tiers(), checker.facts(), checker.usual());
        Ok(Self { graph: Arc::new(graph), warnings, tiers, claims, facts, usual })
    }

    /// The meaning of a fact, as the pipeline declares it.
    pub fn fact_meaning(&self, name: &str) -> Option<&str> {
        let (_, meaning) = self.facts.iter().find(|(known, _)| known == name)?;
        Some(meaning)
    }

    /// The color state of a wire; `None` for tables and values, and for wires that the graph does not have.
    pub fn wire_state(&self, wire: &str) -> Option<ColorState> {
        if let Some(input) = self.graph.inputs.iter().find(|input| input.name == wire) {
            return input.block.is_none().then_some(input.state);
        }
        let (node, port) = wire.rsplit_once('.')?;
        let (_, node) = self.graph.node(node)?;
        let output = node.kind().outputs().iter().position(|output| output.name == port)?;
        *node.states.get(output)?
    }

    /// The type of a wire.
    pub fn wire_type(&self, wire: &str) -> Option<PortType> {
        if let Some(input) = self.graph.inputs.iter().position(|input| input.name == wire) {
            return Some(self.graph.port_type(Source::Input(input)));
        }
        let (node, port) = wire.rsplit_once('.')?;
        let (_, node) = self.graph.node(node)?;
        Some(node.kind().outputs().iter().find(|output| output.name == port)?.ty)
    }
}

/// The answer of what writes changes and edits into a text of a project.
///
/// # Errors
/// The text has errors, or the question has.
pub(super) fn ask_saver<T>(
    project: &dyn Project,
    text: &str,
    ask: impl FnOnce(&Saver<'_>) -> Result<T, Diagnostics>,
) -> Result<T, Diagnostics> {
    let (mut ask, mut answer) = (Some(ask), None);
    project.with_saver(text, &mut |saver| answer = ask.take().map(|ask| ask(saver)))?;
    answer.expect("a project calls back once")
}

/// A pipeline that lies in memory: a built-in one, or a text that was pasted. It has no place to be written to, unless
/// [one is given](Self::stored_by).
pub struct TextProject {
    name: String,
    written: String,
    registry: Registry,
    store: Option<Store>,
}

/// Notes the built-in files that are read.
#[derive(Default)]
struct NotingBuiltIn(RefCell<BTreeMap<String, Arc<[u8]>>>);

impl Loader for NotingBuiltIn {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let bytes = BuiltIn.load(path)?;
        self.0.borrow_mut().insert(path.to_owned(), bytes.clone());
        Ok(bytes)
    }
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
        Self { name: name.to_owned(), written: text.to_owned(), registry, store: None }
    }

    /// The same with a place to be written to.
    pub fn stored_by(self, store: Store) -> Self {
        Self { store: Some(store), ..self }
    }

    /// Its text, as it is stored.
    pub fn text(&self) -> &str {
        &self.written
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

    fn read(&mut self) -> Result<Option<String>, Diagnostics> {
        Ok(Some(self.written.clone()))
    }

    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        Checked::of(&self.name, text, tier, &self.registry, &BuiltIn)
    }

    fn has_changed(&mut self) -> bool {
        false
    }

    fn with_saver(&self, text: &str, ask: &mut dyn FnMut(&Saver<'_>)) -> Result<(), Diagnostics> {
        ask(&Saver::new(&self.name, text, &self.registry, &BuiltIn)?);
        Ok(())
    }

    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        BuiltIn.load(path)
    }

    fn has_place(&self) -> bool {
        self.store.is_some()
    }

    fn write(&mut self, text: &str) -> Result<String, String> {
        let store = self.store.as_ref().ok_or_else(|| format!("{} has no file yet", self.name))?;
        let place = store(&self.name, text)?;
        self.written = text.to_owned();
        Ok(place)
    }

    fn files_in_memory(&self, text: &str) -> Vec<NamedFile> {
        let loader = NotingBuiltIn::default();
        let checked = Checked::of(&self.name, text, None, &self.registry, &loader);
        for tier in checked.map_or(Vec::new(), |checked| checked.tiers) {
            // A tier with errors names files, too.
            let _ = Checked::of(&self.name, text, Some(&tier), &self.registry, &loader);
        }
        loader.0.into_inner().into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::NoFiles;

    use super::*;

    #[test]
    fn a_wire_has_the_state_and_the_type_of_its_port() {
        let text = r#"Pipeline(inputs: { "light": Color, "eye": Camera },
            nodes: { "room": DemoScene(), "bins": Histogram(source: "light") },
            outputs: { "room": "room", "light": "light" })"#;
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
        let checked = Checked::of("wires.ron", text, None, &registry, &NoFiles);
        let checked = checked.unwrap_or_else(|errors| panic!("{errors}"));
        for (wire, state, ty) in [
            ("light", Some(ColorState::Scene), Some(PortType::Image)),
            ("eye", None, Some(PortType::Block)),
            ("room.result", Some(ColorState::Scene), Some(PortType::Image)),
            ("room.depth", Some(ColorState::Data), Some(PortType::Image)),
            ("bins.result", None, Some(PortType::Table)),
            ("bins.nothing", None, None),
            ("nothing.result", None, None),
        ] {
            assert_eq!((checked.wire_state(wire), checked.wire_type(wire)), (state, ty), "{wire}");
        }
    }
}
