//! `afterimage view`: the viewer on files of this machine.

mod open;
mod project;

use std::path::Path;

use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_view::{Desktop, Images, Problem, Project, Scene, TextProject};

use crate::args::PipelineOptions;
use crate::args::view::ViewArgs;
use crate::built_in::hint;
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::PipelineFile;
use open::Opener;

/// The pipeline that is shown if none is named.
const FIRST: &str = "tsushima";

pub(crate) fn run(args: &ViewArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    check_fact_names(args, tables)?;
    let opener = Opener::new(args, tables);
    let images = args.input.clone().map(|file| opener.clone().images(file));
    let size = Size::new(args.size.0, args.size.1);
    let desktop = Desktop {
        adapter: args.adapter.clone(),
        size: [args.window.0.into(), args.window.1.into()],
        project: project(args, &opener)?,
        wake: opener.wake.clone(),
        images: Box::new(move |gpu| match &images {
            Some(images) => images(gpu),
            None => Ok(Images::Scene(Box::new(Scene::new(gpu, size)?))),
        }),
        new_file: Box::new({
            let opener = opener.clone();
            move |path, named| opener.new_file(path, named)
        }),
        open: Box::new(move |gpu, path| opener.open(gpu, path)),
        tier: args.tier.clone(),
        facts: crate::pipeline::fact_list(&args.facts)?,
    };
    Ok(desktop.run()?)
}

/// A fact that the pipeline does not know is a typing error. A pipeline with errors is shown with them.
fn check_fact_names(args: &ViewArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.facts.is_empty() {
        return Ok(());
    }
    let path = args.pipeline.as_deref().unwrap_or(Path::new(FIRST));
    let Ok(document) = read_document(path) else { return Ok(()) };
    let registry = registry(tables, &args.kinds)?;
    let files = Files::of(path, &args.kinds);
    let (tier, facts, kinds) = (args.tier.clone(), args.facts.clone(), args.kinds.clone());
    let options = PipelineOptions { sets: Vec::new(), facts, tier, kinds };
    match PipelineFile::new(&document, &registry, &files).check(&options) {
        Ok(_) | Err(Failure::Pipeline(_)) => Ok(()),
        Err(failure) => Err(failure),
    }
}

/// The named file, a built-in pipeline of that name, or the first one.
fn project(args: &ViewArgs, opener: &Opener) -> Result<Box<dyn Project>, Failure> {
    let Some(path) = &args.pipeline else {
        return Ok(Box::new(TextProject::built_in(FIRST).expect("it is built in")));
    };
    // Also a link in a circle, which the project reports.
    if path.symlink_metadata().is_ok() {
        return Ok(Box::new(opener.project(path)));
    }
    let name = path.to_string_lossy();
    if let Some(project) = TextProject::built_in(name.trim_end_matches(".ron")) {
        return Ok(Box::new(project));
    }
    Err(Failure::unreadable(format!("there is no file `{name}`")).hint(hint(&name)))
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Pipeline(errors) => Self::Pipeline(errors),
            Problem::Message { message, hint: Some(hint) } => Self::machine(message).hint(hint),
            other => Self::machine(other),
        }
    }
}
