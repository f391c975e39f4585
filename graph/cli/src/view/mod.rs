//! `afterimage view`: the viewer on files of this machine.

mod open;
mod project;

use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_pipelines::PIPELINES;
use afterimage_view::{Desktop, Images, Problem, Project, Scene, TextProject};

use crate::args::view::ViewArgs;
use crate::failure::Failure;
use open::Opener;

/// The pipeline that is shown if none is named.
const FIRST: &str = "tsushima";

pub(crate) fn run(args: &ViewArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
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
        open: Box::new(move |gpu, path| opener.open(gpu, path)),
        tier: args.tier.clone(),
        facts: crate::pipeline::fact_list(&args.facts)?,
    };
    Ok(desktop.run()?)
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
    let names: Vec<&str> = PIPELINES.iter().map(|(name, _)| *name).collect();
    Err(Failure::unreadable(format!("there is no file `{name}`"))
        .hint(format!("name a .ron file, or one of the built-in pipelines: {}", names.join(", "))))
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
