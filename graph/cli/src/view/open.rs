//! Files that the viewer opens: pipelines, images and sequences.

use std::path::Path;
use std::rc::Rc;

use afterimage_gpu::Gpu;
use afterimage_graph::node::NodeKind;
use afterimage_media::{Budget, FileError, read_within, sequence};
use afterimage_view::{Files, Images, Opened, Problem};

use super::project::FileProject;
use crate::args::KindOptions;
use crate::args::view::ViewArgs;

/// How files are opened.
#[derive(Clone)]
pub(super) struct Opener {
    options: KindOptions,
    kinds: Rc<Vec<NodeKind>>,
    budget: Budget,
    fps: f64,
}

/// Makes images on a device.
type MakeImages = Box<dyn Fn(&Gpu) -> Result<Images, Problem>>;

impl Opener {
    pub(super) fn new(args: &ViewArgs, tables: &[&[NodeKind]]) -> Self {
        let kinds = Rc::new(tables.iter().flat_map(|table| table.iter().cloned()).collect());
        Self { options: args.kinds.clone(), kinds, budget: args.images.budget(), fps: f64::from(args.fps) }
    }

    pub(super) fn project(&self, path: &Path) -> FileProject {
        FileProject::new(path.to_owned(), self.options.clone(), self.kinds.to_vec())
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
            let (budget, count) = (self.budget, sources.len());
            let read = move |index: usize| {
                let source: &(_, afterimage_media::Source) = &sources[index];
                read_within(&source.1, budget).map_err(|error| error.to_string())
            };
            Ok(Images::Files(Files::new(gpu, count, self.fps, Box::new(read))?))
        })
    }
}

fn unreadable(error: &FileError) -> Problem {
    Problem::said(error.to_string())
}
