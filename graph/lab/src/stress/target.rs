//! A pipeline or a kind on its own, as a target of the tests.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, NoFiles, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::{NodeKind, PortType, Registry};

use super::wiring::{NODE, WireOptions, pipeline_text};

/// Overrides of parameters: `node.parameter` and its value, as `--set` takes them.
pub type Overrides = Vec<(String, String)>;

/// A pipeline or a kind.
#[derive(Clone)]
pub struct Target {
    pub title: String,
    /// The arguments after `afterimage stress` that choose it.
    pub(crate) words: String,
    document: Arc<Document>,
    /// The pipeline in which the kind is never skipped as an identity; for kinds with image outputs.
    forced: Option<Arc<Document>>,
    tier: Option<String>,
    /// The kinds of its nodes.
    pub(crate) registry: Arc<Registry>,
    /// Reads the files that the pipeline names.
    loader: &'static dyn Loader,
    pub(crate) is_kind: bool,
    /// It is a kind whose main output is a value.
    pub(crate) shows_value: bool,
    /// Optional inputs have no image.
    pub bare: bool,
    /// Its parameters are swept over their domains.
    pub(crate) sweep: bool,
    pub base: Overrides,
    pub facts: Facts,
}

/// The file for kinds with a file parameter: a table with two nodes a side that mixes and bends the channels.
const CUBE: &str = "stress.cube";
const CUBE_TEXT: &str = "LUT_3D_SIZE 2\n0 0.1 0\n0.9 0 0.1\n0 0 0.8\n1 0.2 1\n0.1 1 0\n0.8 1 0.3\n0 0.9 1\n1 1 1\n";

/// A file of a size that films use.
const TYPICAL_CUBE: &str = "typical.cube";
const TYPICAL_NODES: u32 = 33;

/// The text of a table of that many nodes a side, which bends each channel.
fn typical_cube(nodes: u32) -> String {
    let bent = |index: u32| (f64::from(index) / f64::from(nodes - 1)).powf(0.9);
    let lines = (0..nodes.pow(3)).map(|at| {
        let [r, g, b] = [at % nodes, at / nodes % nodes, at / nodes / nodes].map(bent);
        format!("{r:.6} {g:.6} {b:.6}\n")
    });
    format!("LUT_3D_SIZE {nodes}\n{}", lines.collect::<String>())
}

struct CubeFile;

impl Loader for CubeFile {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        match path {
            CUBE => Ok(CUBE_TEXT.as_bytes().into()),
            TYPICAL_CUBE => Ok(typical_cube(TYPICAL_NODES).into_bytes().into()),
            _ => NoFiles.load(path),
        }
    }
}

impl Target {
    /// A pipeline from its text; `words` choose it on the command line.
    ///
    /// # Errors
    /// The text is not a pipeline.
    pub fn pipeline(
        title: &str,
        words: &str,
        file: &str,
        text: &str,
        registry: &Arc<Registry>,
        loader: &'static dyn Loader,
    ) -> Result<Self, Diagnostics> {
        Ok(Self {
            title: title.to_owned(),
            words: words.to_owned(),
            document: Arc::new(parse(file, text)?),
            forced: None,
            tier: None,
            registry: registry.clone(),
            loader,
            is_kind: false,
            shows_value: false,
            bare: false,
            sweep: true,
            base: Overrides::new(),
            facts: Facts::default(),
        })
    }

    /// A kind on its own, with its optional inputs, or `bare` without.
    ///
    /// # Errors
    /// No kind makes one of its inputs or reads one of its outputs: which, and what makes it reachable.
    pub fn kind(registry: &Arc<Registry>, kind: &NodeKind, bare: bool) -> Result<Self, String> {
        Self::with_or_without_file(registry, kind, WireOptions { bare, file: CUBE, ..WireOptions::default() })
    }

    /// A kind as it is used most: with its optional images, without optional values, and only its main output is read.
    /// A file is a table of 33 nodes a side.
    ///
    /// # Errors
    /// As [`kind`](Self::kind).
    pub fn typical(registry: &Arc<Registry>, kind: &NodeKind) -> Result<Self, String> {
        let wiring = WireOptions { typical: true, file: TYPICAL_CUBE, ..WireOptions::default() };
        Self::with_or_without_file(registry, kind, wiring)
    }

    fn with_or_without_file(
        registry: &Arc<Registry>,
        kind: &NodeKind,
        wiring: WireOptions<'static>,
    ) -> Result<Self, String> {
        let target = Self::wired(registry, kind, wiring)?;
        // A kind whose files are not tables runs without a file.
        match target.graph(&Overrides::new()) {
            Ok(_) => Ok(target),
            Err(_) => Self::wired(registry, kind, WireOptions { file: "", ..wiring }),
        }
    }

    fn wired(registry: &Arc<Registry>, kind: &NodeKind, wiring: WireOptions<'static>) -> Result<Self, String> {
        let bare = wiring.bare;
        let name = kind.name();
        let (title, flag) = if bare { (" (bare)", " --bare") } else { ("", "") };
        let document = |forced: bool| {
            let text = pipeline_text(registry, kind, WireOptions { forced, ..wiring })?;
            Ok::<_, String>(Arc::new(parse(&format!("{name}.ron"), &text).expect("the wiring writes pipelines")))
        };
        Ok(Self {
            title: format!("{name}{title}"),
            words: format!("--kind {name}{flag}"),
            document: document(false)?,
            forced: document(true).ok(),
            tier: None,
            registry: registry.clone(),
            loader: &CubeFile,
            is_kind: true,
            shows_value: kind.output(kind.main_output()).is_some_and(|output| output.ty == PortType::Value),
            bare,
            sweep: true,
            base: Overrides::new(),
            facts: Facts::default(),
        })
    }

    /// The names of the pipeline's tiers.
    pub(crate) fn tiers(&self) -> impl Iterator<Item = &str> {
        self.document.tiers.iter().map(|(name, _)| name.value.as_str())
    }

    /// True if the pipeline has optional inputs.
    pub(crate) fn has_optional_inputs(&self) -> bool {
        self.document.inputs.iter().any(|input| input.optional)
    }

    /// The pipeline at a tier.
    pub(crate) fn at_tier(&self, tier: Option<&str>) -> Self {
        let Some(tier) = tier else { return self.clone() };
        Self {
            title: format!("{} ({tier})", self.title),
            words: format!("{} --tier {tier}", self.words),
            tier: Some(tier.to_owned()),
            sweep: false,
            ..self.clone()
        }
    }

    /// The pipeline without images for its optional inputs.
    pub(crate) fn without_optional(&self) -> Self {
        let (title, words) = (format!("{} (bare)", self.title), format!("{} --bare", self.words));
        Self { title, words, bare: true, sweep: false, ..self.clone() }
    }

    /// The same, with more arguments.
    pub fn with_words(&self, more: &str) -> Self {
        Self { words: format!("{}{more}", self.words), ..self.clone() }
    }

    /// The graph with these overrides, or what is wrong with them.
    pub fn graph(&self, overrides: &Overrides) -> Result<Graph, Diagnostics> {
        self.check(&self.document, overrides)
    }

    /// The graph in which the kind always runs.
    pub(crate) fn forced(&self, overrides: &Overrides) -> Option<Graph> {
        self.check(self.forced.as_ref()?, overrides).ok()
    }

    fn check(&self, document: &Document, overrides: &Overrides) -> Result<Graph, Diagnostics> {
        let sets = self.base.iter().chain(overrides).cloned().collect();
        let options = CheckOptions { tier: self.tier.clone(), sets, loader: self.loader };
        Ok(check(document, &self.registry, &options)?.0)
    }

    /// True for nodes whose parameters are swept.
    pub(crate) fn sweeps(&self, node: &str) -> bool {
        !self.is_kind || node == NODE
    }
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::NoFiles;

    use super::super::{pipelines, registry};

    /// The tiers of a pipeline have the domains of its parameters in common.
    #[test]
    fn values_are_swept_once_and_not_for_every_tier() {
        let text = r#"Pipeline(
            inputs: { "scene": Color, "shade": Albedo(optional: true) },
            nodes: { "bins": Histogram(source: "scene", albedo: "shade") },
            outputs: { "out": "scene" },
            tiers: { "low": { "bins.lo": -8.0 } },
        )"#;
        let registry = registry(&[]).expect("no two kinds share a name");
        let targets = pipelines("a", "a", "a.ron", text, &registry, &NoFiles, None).expect("a pipeline");
        let found: Vec<_> = targets.iter().map(|target| (&*target.title, &*target.words, target.sweep)).collect();
        assert_eq!(found, [("a", "a", true), ("a (bare)", "a --bare", false), ("a (low)", "a --tier low", false)]);
    }
}
