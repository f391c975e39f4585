//! From a pipeline file to a graph and a plan, for every command.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, check};
use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_graph::document::parse;
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

/// Remembers which files were asked for, whether they are there or not.
#[derive(Default)]
struct Noted(RefCell<BTreeSet<PathBuf>>);

impl Loader for Noted {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.0.borrow_mut().insert(path.into());
        Files.load(path)
    }
}

/// The pipeline's file and all that it names: those that it extends or uses, looks, tables. As far as it can be read.
pub(crate) fn files_of(path: &Path, tables: &[&[NodeKind]], options: &PipelineOptions) -> BTreeSet<PathBuf> {
    let noted = Noted::default();
    if let (Ok(registry), Ok(text)) = (registry(tables, &options.nodes), read_text(path, "pipeline"))
        && let Ok(document) = parse(&path.to_string_lossy(), &text)
    {
        let options = CheckOptions { tier: options.tier.clone(), sets: Vec::new(), loader: &noted };
        // Whatever is wrong is told by those who want the pipeline.
        let _ = check(&document, &registry, &options);
    }
    let mut files = noted.0.into_inner();
    files.insert(path.to_owned());
    files
}

/// The text of a file; the failure says what it was needed for.
pub(crate) fn read_text(path: &Path, what: &str) -> Result<String, Failure> {
    let failed = |why: String| Failure::user(format!("cannot read the {what} `{}`: {why}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failed(why_not(path, &error)))?;
    String::from_utf8(bytes).map_err(|error| {
        let whole = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = whole.iter().filter(|byte| **byte == b'\n').count() + 1;
        failed(format!("line {line} is no text in UTF-8")).hint("save the file in that encoding")
    })
}

/// Why a file cannot be read, in the words of its user.
fn why_not(path: &Path, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    // An empty path is the folder itself.
    if path.is_dir() || path.as_os_str().is_empty() {
        return "it is a folder".into();
    }
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "you may not read it".into(),
        _ => error.to_string(),
    }
}

/// The kinds of the program and those of plug-in folders.
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

/// The kinds in a folder: the folder itself if it holds a `node.ron`, or each folder in it that does.
pub(crate) fn folder_kinds(folder: &Path) -> Result<Vec<NodeKind>, Failure> {
    if folder.join("node.ron").is_file() {
        return Ok(vec![folder_node(folder)?]);
    }
    let entries = std::fs::read_dir(folder)
        .map_err(|error| Failure::user(format!("`{}` holds no node kinds: {error}", folder.display())))?;
    let mut folders: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.retain(|path| path.join("node.ron").is_file());
    folders.sort();
    if folders.is_empty() {
        return Err(Failure::user(format!("no folder in `{}` holds a `node.ron`", folder.display())));
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

/// A checked pipeline; its warnings are printed.
pub(crate) fn load_graph(path: &Path, registry: &Registry, options: &PipelineOptions) -> Result<Graph, Failure> {
    let (graph, warnings) = check_file(path, registry, options)?;
    if !warnings.is_empty() {
        note(&warnings.render(Style::Coloured));
    }
    Ok(graph)
}

/// A checked pipeline and its warnings.
pub(crate) fn check_file(
    path: &Path,
    registry: &Registry,
    options: &PipelineOptions,
) -> Result<(Graph, Diagnostics), Failure> {
    let text = read_text(path, "pipeline")?;
    check_text(&path.to_string_lossy(), &text, registry, options)
}

/// A checked pipeline from its text, and its warnings.
pub(crate) fn check_text(
    name: &str,
    text: &str,
    registry: &Registry,
    options: &PipelineOptions,
) -> Result<(Graph, Diagnostics), Failure> {
    check_with(&Files, name, text, registry, options)
}

/// The same with files from elsewhere.
pub(crate) fn check_with(
    loader: &dyn Loader,
    name: &str,
    text: &str,
    registry: &Registry,
    options: &PipelineOptions,
) -> Result<(Graph, Diagnostics), Failure> {
    let sets = options.sets.iter().map(|set| split(set, "--set")).collect::<Result<_, _>>()?;
    let check_options = CheckOptions { tier: options.tier.clone(), sets, loader };
    let (graph, warnings) = check(&parse(name, text)?, registry, &check_options)?;
    refuse_unknown_facts(&graph, options)?;
    Ok((graph, warnings))
}

/// The tiers of a file and of those that it extends, its own first.
pub(crate) fn tier_names(path: &Path) -> Result<Vec<String>, Failure> {
    let mut names: Vec<String> = Vec::new();
    let mut next = Some(path.to_owned());
    while let Some(path) = next.take() {
        let text = read_text(&path, "pipeline")?;
        let document = parse(&path.to_string_lossy(), &text)?;
        for (name, _) in &document.tiers {
            if !names.contains(&name.value) {
                names.push(name.value.clone());
            }
        }
        // Whoever asks has checked the file, so the chain ends.
        next = document.extends.map(|base| path.with_file_name("").join(base.value));
    }
    Ok(names)
}

/// `name=value`.
pub(crate) fn split(text: &str, flag: &str) -> Result<(String, String), Failure> {
    let (name, value) = text.split_once('=').ok_or_else(|| {
        Failure::user(format!("`{flag} {text}` has no `=`")).hint(format!("write `{flag} name=value`"))
    })?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}

/// A fact that no condition asks is a slip of the pen, and silence would hide it.
fn refuse_unknown_facts(graph: &Graph, options: &PipelineOptions) -> Result<(), Failure> {
    let asked: Vec<String> = graph
        .nodes
        .iter()
        .filter_map(|node| node.when.as_ref())
        .flat_map(|when| when.facts())
        .map(str::to_owned)
        .collect();
    for fact in &options.facts {
        let (name, _) = split(fact, "--fact")?;
        if !asked.contains(&name) {
            let mut known = asked.clone();
            known.sort();
            known.dedup();
            let hint = if known.is_empty() {
                "it asks no facts at all".into()
            } else {
                format!("it asks `{}`", known.join("`, `"))
            };
            return Err(Failure::user(format!("no `when` of this pipeline asks the fact `{name}`")).hint(hint));
        }
    }
    Ok(())
}

/// What the command line says of the scene.
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

/// The planner's switches.
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

/// A plan without a device: for one that can store every format and has half-precision arithmetic and subgroups, on half-float inputs of that size.
pub(crate) fn plan_without_device(graph: &Graph, size: Size, facts: Facts, options: Options) -> Result<Plan, Failure> {
    let caps = Caps {
        storage: Format::ALL.into(),
        max_side: 16384,
        half_arithmetic: true,
        subgroups: true,
        ..Caps::default()
    };
    Ok(plan(graph, &setting(graph, size, facts, options, caps, &Requirement::typical))?)
}

/// A setting with half-float images of one size at all required inputs.
pub(crate) fn setting<'a>(
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
