//! Files that the viewer opens: pipelines, images and sequences.

use std::path::Path;
use std::rc::Rc;

use afterimage_gpu::Gpu;
use afterimage_graph::node::NodeKind;
use afterimage_media::{Budget, FileError, FileWatch, read_within, sequence};
use afterimage_view::{Files, Images, NamedFile, Opened, Problem, Project, Wake};

use super::project::FileProject;
use crate::args::KindOptions;
use crate::args::view::ViewArgs;

#[derive(Clone)]
pub(super) struct Opener {
    options: KindOptions,
    kinds: Rc<Vec<NodeKind>>,
    budget: Budget,
    fps: f64,
    /// Draws a frame when a file has changed.
    pub(super) wake: Wake,
}

/// Makes images on a device.
type MakeImages = Box<dyn Fn(&Gpu) -> Result<Images, Problem>>;

impl Opener {
    pub(super) fn new(args: &ViewArgs, tables: &[&[NodeKind]]) -> Self {
        let kinds = Rc::new(tables.iter().flat_map(|table| table.iter().cloned()).collect());
        let (options, budget, fps) = (args.kinds.clone(), args.images.budget(), f64::from(args.fps));
        Self { options, kinds, budget, fps, wake: Wake::default() }
    }

    pub(super) fn project(&self, path: &Path) -> FileProject {
        FileProject::new(path.to_owned(), self.options.clone(), self.kinds.to_vec(), &self.wake)
    }

    /// The file of a pipeline that has none yet.
    pub(super) fn new_file(&self, path: &Path, named: Vec<NamedFile>) -> Result<Box<dyn Project>, Problem> {
        let project = self.project(path).new_file(named).map_err(Problem::message)?;
        Ok(Box::new(project))
    }

    /// A file that is dropped on the window.
    pub(super) fn open(&self, gpu: &Gpu, path: &Path) -> Result<Opened, Problem> {
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ron")) {
            return Ok(Opened::Pipeline(Box::new(self.project(path))));
        }
        Ok(Opened::Images(self.clone().images(path.to_string_lossy().into_owned())(gpu)?))
    }

    /// The images of a file or of a sequence.
    pub(super) fn images(self, file: String) -> MakeImages {
        Box::new(move |gpu| {
            let sources = sequence::Input::find(&file, None).map_err(|error| unreadable(&error))?.sources();
            let (budget, count, wake) = (self.budget, sources.len(), self.wake.clone());
            let mut watch = FileWatch::new(move || wake.call());
            watch.extend(sources.iter().map(|(_, source)| source.path.clone()));
            let read = move |index: usize| {
                let source: &(_, afterimage_media::Source) = &sources[index];
                read_within(&source.1, budget).map_err(|error| error.to_string())
            };
            let mut files = Files::new(gpu, count, self.fps, Box::new(read))?;
            files.follow_by(Box::new(move || !watch.changed().is_empty()));
            Ok(Images::Files(Box::new(files)))
        })
    }
}

fn unreadable(error: &FileError) -> Problem {
    Problem::message(error.to_string())
}
