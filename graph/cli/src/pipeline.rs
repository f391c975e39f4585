//! From a pipeline file to a graph and a plan.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{Checker, Facts, Graph, Loader};
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{NodeKind, Registry, folder_kind};
use afterimage_plan::{Alias, Caps, GivenImage, Options, Plan, PlanRequest, Requirement, Tiles, plan};

use crate::args::{NoAlias, PipelineOptions, PlanOptions, TileChoice};
use crate::failure::Failure;
use crate::terminal::note;

/// Reads the files that a pipeline names.
pub(crate) struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| why_not(Path::new(path), &error))
    }
}

/// Records which files are loaded, also those that do not exist.
#[derive(Default)]
struct RecordingLoader(RefCell<BTreeSet<PathBuf>>);

impl Loader for RecordingLoader {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.0.borrow_mut().insert(path.into());
        Files.load(path)
    }
}

/// The pipeline file and the files that it names: extended and used pipelines, looks, tables. Files that cannot be read
/// name no others.
pub(crate) fn files_of(path: &Path, tables: &[&[NodeKind]], options: &PipelineOptions) -> BTreeSet<PathBuf> {
    let loader = RecordingLoader::default();
    if let (Ok(registry), Ok(document)) = (registry(tables, &options.nodes), read_document(path)) {
        let file = PipelineFile::with_loader(&document, &registry, &loader);
        // The command that uses the pipeline reports its errors.
        let _ = file.check(&PipelineOptions { sets: Vec::new(), facts: Vec::new(), ..options.clone() });
    }
    let mut files = loader.0.into_inner();
    files.insert(path.to_owned());
    files
}

/// The text of a file; `what` names it in the error.
pub(crate) fn read_text(path: &Path, what: &str) -> Result<String, Failure> {
    let failed = |why: String| Failure::unreadable(format!("cannot read the {what} `{}`: {why}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failed(why_not(path, &error)))?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|byte| **byte == b'\n').count() + 1;
        failed(format!("line {line} is not text in UTF-8")).hint("save the file in that encoding")
    })
}

/// Why a file cannot be read.
fn why_not(path: &Path, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    // An empty path names the current folder.
    if path.is_dir() || path.as_os_str().is_empty() {
        return "it is a folder".into();
    }
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "you may not read it".into(),
        _ => error.to_string(),
    }
}

/// The kinds of the program and of plug-in folders.
pub(crate) fn registry(tables: &[&[NodeKind]], folders: &[PathBuf]) -> Result<Registry, Failure> {
    let mut from_folders = Vec::new();
    for folder in folders {
        from_folders.extend(folder_kinds(folder)?);
    }
    let mut all = tables.to_vec();
    all.push(&from_folders);
    let hint = "a kind of `--nodes` needs a name that no other kind has; `afterimage nodes` lists the built-in ones";
    Registry::new(&all).map_err(|error| Failure::user(error).hint(hint))
}

/// The kinds in a folder: the folder itself if it has a `node.ron`, or each folder in it that has one.
pub(crate) fn folder_kinds(folder: &Path) -> Result<Vec<NodeKind>, Failure> {
    if folder.join("node.ron").is_file() {
        return Ok(vec![folder_node(folder)?]);
    }
    let entries = std::fs::read_dir(folder)
        .map_err(|error| Failure::unreadable(format!("`{}` has no node kinds: {error}", folder.display())))?;
    let mut folders: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.retain(|path| path.join("node.ron").is_file());
    folders.sort();
    if folders.is_empty() {
        return Err(Failure::user(format!("no folder in `{}` has a `node.ron`", folder.display())));
    }
    folders.iter().map(|folder| folder_node(folder)).collect()
}

fn folder_node(folder: &Path) -> Result<NodeKind, Failure> {
    let ron_path = folder.join("node.ron");
    let shader_path = shader_of(folder)?;
    let (ron, shader) = (read_text(&ron_path, "node kind")?, read_text(&shader_path, "shader")?);
    Ok(folder_kind((&ron_path.to_string_lossy(), &ron), (&shader_path.to_string_lossy(), &shader))?)
}

fn shader_of(folder: &Path) -> Result<PathBuf, Failure> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| Failure::user(format!("`{}`: {error}", folder.display())))?;
    let mut shaders: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    shaders.retain(|path| path.extension().is_some_and(|ending| ending == "wgsl"));
    match shaders.as_slice() {
        [one] => Ok(one.clone()),
        more => {
            Err(Failure::user(format!("`{}` has {} `.wgsl` files beside its `node.ron`", folder.display(), more.len()))
                .hint("a kind has exactly one, called like the kind in snake case: `posterize.wgsl` for `Posterize`"))
        }
    }
}

/// A parsed pipeline file, which is checked for each tier. The files that it names are read once, too.
pub(crate) struct PipelineFile<'a>(Checker<'a>);

/// Reads and parses a pipeline file.
pub(crate) fn read_document(path: &Path) -> Result<Document, Failure> {
    Ok(parse(&path.to_string_lossy(), &read_text(path, "pipeline")?)?)
}

impl<'a> PipelineFile<'a> {
    /// A pipeline that names files of the file system.
    pub(crate) fn new(document: &'a Document, registry: &'a Registry) -> Self {
        Self(Checker::new(document, registry, &Files))
    }

    /// A pipeline whose files `loader` reads.
    pub(crate) fn with_loader(document: &'a Document, registry: &'a Registry, loader: &'a dyn Loader) -> Self {
        Self(Checker::new(document, registry, loader))
    }

    /// The graph; prints the warnings.
    pub(crate) fn graph(&self, options: &PipelineOptions) -> Result<Graph, Failure> {
        let (graph, warnings) = self.check(options)?;
        if !warnings.is_empty() {
            note(&warnings.render(Style::Coloured));
        }
        Ok(graph)
    }

    /// The graph and the warnings.
    pub(crate) fn check(&self, options: &PipelineOptions) -> Result<(Graph, Diagnostics), Failure> {
        let sets = options.sets.iter().map(|set| split(set, "--set")).collect::<Result<Vec<_>, _>>()?;
        let (graph, warnings) = self.0.check(options.tier.as_deref(), &sets)?;
        refuse_unknown_facts(&graph, options)?;
        Ok((graph, warnings))
    }

    /// The tiers of the file and of the files that it extends.
    pub(crate) fn tiers(&self) -> Vec<String> {
        self.0.tiers()
    }
}

/// A checked pipeline file, for commands that need it once; prints the warnings.
pub(crate) fn load_graph(path: &Path, registry: &Registry, options: &PipelineOptions) -> Result<Graph, Failure> {
    PipelineFile::new(&read_document(path)?, registry).graph(options)
}

/// `name=value`.
pub(crate) fn split(text: &str, flag: &str) -> Result<(String, String), Failure> {
    let (name, value) = text.split_once('=').ok_or_else(|| {
        Failure::user(format!("`{flag} {text}` has no `=`")).hint(format!("write `{flag} name=value`"))
    })?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}

/// Refuses facts that no condition uses: they are typing errors.
fn refuse_unknown_facts(graph: &Graph, options: &PipelineOptions) -> Result<(), Failure> {
    let used: Vec<String> = graph
        .nodes
        .iter()
        .filter_map(|node| node.when.as_ref())
        .flat_map(|when| when.facts())
        .map(str::to_owned)
        .collect();
    for fact in &options.facts {
        let (name, _) = split(fact, "--fact")?;
        if !used.contains(&name) {
            let mut known = used.clone();
            known.sort();
            known.dedup();
            let hint =
                if known.is_empty() { "it uses no facts".into() } else { format!("it uses `{}`", known.join("`, `")) };
            return Err(Failure::user(format!("no `when` of this pipeline uses the fact `{name}`")).hint(hint));
        }
    }
    Ok(())
}

/// The facts of the command line.
pub(crate) fn facts(options: &PipelineOptions) -> Result<Facts, Failure> {
    let mut facts = Facts::default();
    for fact in &options.facts {
        let (name, value) = split(fact, "--fact")?;
        match (value.parse::<bool>(), value.parse::<f64>()) {
            (Ok(flag), _) => facts.set(name, flag),
            (_, Ok(number)) if number.is_finite() => facts.set(name, number),
            _ => return Err(Failure::user(format!("`--fact {fact}`: a fact is `true`, `false` or a number"))),
        }
    }
    Ok(facts)
}

/// The planner's options.
pub(crate) fn plan_options(options: &PlanOptions) -> Options {
    let alias = match options.no_alias {
        None => Alias::Placed,
        Some(NoAlias::Placed) => Alias::Pool,
        Some(NoAlias::All) => Alias::None,
    };
    Options {
        fuse: !options.no_fuse,
        tile: match options.tiles {
            TileChoice::Never => Tiles::Never,
            TileChoice::Auto => Tiles::WhereItPays,
            TileChoice::Always => Tiles::Always,
        },
        alias,
        serial: options.serial,
        exact: options.exact,
        batches_first: options.fewest_batches,
        bounds_checks: options.bounds_checks,
        ..Options::default()
    }
}

/// A plan for a typical device, which stores every format and has half-precision arithmetic and subgroups, with
/// half-float inputs of this size.
pub(crate) fn plan_without_device(graph: &Graph, size: Size, facts: Facts, options: Options) -> Result<Plan, Failure> {
    let caps = Caps {
        storage: Format::ALL.into(),
        max_side: 16384,
        half_arithmetic: true,
        subgroups: true,
        ..Caps::default()
    };
    Ok(plan(graph, &request(graph, size, facts, options, caps, &Requirement::typical))?)
}

/// A request with half-float images of one size for all required inputs.
pub(crate) fn request<'a>(
    graph: &Graph,
    size: Size,
    facts: Facts,
    options: Options,
    caps: Caps,
    requirement: &'a dyn Fn(&ImageDesc) -> Requirement,
) -> PlanRequest<'a> {
    let given = GivenImage { desc: ImageDesc::new(size), finite: false };
    let required = graph.inputs.iter().filter(|input| !input.optional);
    let inputs: BTreeMap<String, GivenImage> = required.map(|input| (input.name.clone(), given)).collect();
    PlanRequest { size, inputs, facts, caps, options, requirement }
}
