//! From a pipeline file to a graph and a plan.

use std::path::Path;

use afterimage_graph::check::{Checker, FactKind, Facts, Graph};
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Style, list, quote};
use afterimage_graph::document::Document;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan_without_tables};

use crate::args::{KindOptions, PipelineOptions};
use crate::failure::Failure;
use crate::files::{FileLoader, Files, read_document, registry};
use crate::terminal::note_styled;

/// A pipeline file as it was read, with the kinds that it has and access to the files that it names.
pub(crate) struct PipelineSource {
    pub(crate) registry: Registry,
    document: Document,
    files: Files,
}

impl PipelineSource {
    pub(crate) fn read(path: &Path, tables: &[&[NodeKind]], options: &KindOptions) -> Result<Self, Failure> {
        let registry = registry(tables, options, Some(path))?;
        Ok(Self { registry, document: read_document(path)?, files: Files::of(path, options) })
    }

    pub(crate) fn file(&self) -> PipelineFile<'_> {
        PipelineFile::new(&self.document, &self.registry, &self.files)
    }
}

/// A parsed pipeline file, which is checked for each tier. The files that it names are read once, too.
pub(crate) struct PipelineFile<'a>(Checker<'a>);

impl<'a> PipelineFile<'a> {
    /// A pipeline whose files `loader` reads. No output may replace those that it names, also for other tiers.
    pub(crate) fn new<L: FileLoader>(document: &'a Document, registry: &'a Registry, loader: &'a L) -> Self {
        let checker = Checker::new(document, registry, loader);
        list_files(&checker, loader);
        Self(checker)
    }

    /// The graph; prints the warnings.
    pub(crate) fn graph(&self, options: &PipelineOptions) -> Result<Graph, Failure> {
        let (graph, warnings) = self.check(options)?;
        if !warnings.is_empty() {
            note_styled(&warnings.render(Style::Colored));
        }
        Ok(graph)
    }

    /// The graph and the warnings.
    pub(crate) fn check(&self, options: &PipelineOptions) -> Result<(Graph, Diagnostics), Failure> {
        let sets = assignments(&options.sets, "--set")?;
        let (graph, mut warnings) = self.0.check(options.tier.as_deref(), &sets)?;
        let declared: Vec<String> = self.0.facts().into_iter().map(|(name, _)| name).collect();
        check_facts(&graph, &declared, &options.facts, &mut warnings)?;
        Ok((graph, warnings))
    }

    /// The tiers of the file and of the files that it extends.
    pub(crate) fn tiers(&self) -> Vec<String> {
        self.0.tiers()
    }
}

/// Adds the files that a pipeline names to those of the run.
pub(crate) fn list_files(checker: &Checker<'_>, loader: &impl FileLoader) {
    checker.named_files().iter().for_each(|path| loader.name(path));
}

/// `name=value` of each use of an option; a name has one.
pub(crate) fn assignments(texts: &[String], flag: &str) -> Result<Vec<(String, String)>, Failure> {
    let mut all: Vec<(String, String)> = Vec::new();
    for text in texts {
        let (name, value) = split(text, flag)?;
        if all.iter().any(|(known, _)| *known == name) {
            return Err(Failure::user(format!("`{flag} {name}=` is there twice")).hint("name one value"));
        }
        all.push((name, value));
    }
    Ok(all)
}

/// `name=value`.
pub(crate) fn split(text: &str, flag: &str) -> Result<(String, String), Failure> {
    let (name, value) = text.split_once('=').ok_or_else(|| {
        Failure::user(format!("`{flag} {text}` has no `=`")).hint(format!("write `{flag} name=value`"))
    })?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}

/// Refuses facts that the pipeline does not know or takes for another kind of value: they are typing errors. Warns of
/// facts that it declares and nothing reads.
pub(crate) fn check_facts(
    graph: &Graph,
    declared: &[String],
    given: &[String],
    warnings: &mut Diagnostics,
) -> Result<(), Failure> {
    let read = graph.facts();
    for fact in given {
        let (name, value) = split(fact, "--fact")?;
        let is_number = value.parse::<f64>().is_ok();
        match read.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind) {
            Some(FactKind::Flag) if is_number => {
                let meant = value.parse() != Ok(0.0);
                return Err(Failure::user(format!("`--fact {fact}`: this fact is `true` or `false`, not a number"))
                    .hint(format!("write `--fact {name}={meant}`")));
            }
            Some(FactKind::Number) if !is_number => {
                return Err(Failure::user(format!("`--fact {fact}`: this fact is a number")));
            }
            Some(_) => {}
            None if declared.contains(&name) => {
                let message = format!("no `when` of this pipeline reads the fact {}", quote(&name));
                warnings.push(Diagnostic::warning("unread-fact", message));
            }
            None => {
                let known: Vec<&str> = read.iter().map(|(name, _)| name.as_str()).collect();
                let uses = || format!("it uses {}", list(known.iter().copied(), 16));
                let hint = if known.is_empty() { "it uses no facts".to_owned() } else { uses() };
                return Err(Failure::user(format!("no `when` of this pipeline uses the fact `{name}`")).hint(hint));
            }
        }
    }
    Ok(())
}

/// The facts of the command line.
pub(crate) fn facts(options: &PipelineOptions) -> Result<Facts, Failure> {
    fact_list(&options.facts)
}

/// The facts of each use of `--fact`.
pub(crate) fn fact_list(texts: &[String]) -> Result<Facts, Failure> {
    let mut facts = Facts::default();
    for fact in texts {
        let (name, value) = split(fact, "--fact")?;
        match (value.parse::<bool>(), value.parse::<f64>()) {
            (Ok(flag), _) => facts.set(name, flag),
            (_, Ok(number)) if number.is_finite() => facts.set(name, number),
            _ => return Err(Failure::user(format!("`--fact {fact}`: a fact is `true`, `false` or a number"))),
        }
    }
    Ok(facts)
}

/// A typical graphics card: it stores every format, and its workgroups share a fast memory.
pub(crate) fn typical_caps() -> Caps {
    Caps { storage: Format::ALL.into(), max_side: 16384, fast_workgroup_memory: true, ..Caps::default() }
}

/// A plan for a typical device with half-float inputs of this size, to look at and not to run.
pub(crate) fn plan_without_device(graph: &Graph, size: Size, facts: Facts, options: Options) -> Result<Plan, Failure> {
    Ok(plan_without_tables(graph, &request(graph, size, facts, options, typical_caps(), &Requirement::typical))?)
}

/// A request with half-float images of one size, and blocks, for all required inputs.
pub(crate) fn request<'a>(
    graph: &Graph,
    size: Size,
    facts: Facts,
    options: Options,
    caps: Caps,
    requirement: &'a dyn Fn(&ImageDesc) -> Requirement,
) -> PlanRequest<'a> {
    let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    let given = HostInputs::all(size, graph.inputs.iter().filter(|input| !input.optional), image);
    PlanRequest { given, facts, caps, options, dynamic: Default::default(), requirement }
}
