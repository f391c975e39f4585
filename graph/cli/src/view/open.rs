//! Files that the viewer opens: pipelines, images, cameras and sequences.

use std::path::Path;
use std::rc::Rc;

use afterimage_graph::check::GraphInput;
use afterimage_graph::node::NodeKind;
use afterimage_media::{Budget, FileWatch, Source, read_description, read_within, real_path, sequence};
use afterimage_view::{InputData, InputFile, NamedFile, Opened, Problem, Project, Wake};

use super::project::FileProject;
use crate::args::KindOptions;
use crate::args::files::ReadArgs;
use crate::args::view::ViewArgs;
use crate::cameras::{is_camera, read_camera_file};
use crate::failure::Failure;
use crate::render::volume;

#[derive(Clone)]
pub(super) struct Opener {
    options: KindOptions,
    kinds: Rc<Vec<NodeKind>>,
    reading: ReadArgs,
    slices: Option<u32>,
    budget: Budget,
    fps: f64,
    /// Draws a frame when a file has changed.
    pub(super) wake: Wake,
}

impl Opener {
    pub(super) fn new(args: &ViewArgs, tables: &[&[NodeKind]]) -> Self {
        let kinds = Rc::new(tables.iter().flat_map(|table| table.iter().cloned()).collect());
        let (options, budget, fps) = (args.kinds.clone(), args.images.budget(), f64::from(args.fps));
        let reading = ReadArgs { input_space: args.input_space.clone(), ..ReadArgs::default() };
        Self { options, kinds, reading, slices: args.slices, budget, fps, wake: Wake::default() }
    }

    pub(super) fn project(&self, path: &Path) -> FileProject {
        FileProject::new(path.to_owned(), self.options.clone(), self.kinds.to_vec(), &self.wake)
    }

    /// The file of a pipeline that has none yet.
    pub(super) fn new_file(&self, path: &Path, named: Vec<NamedFile>) -> Result<Box<dyn Project>, Problem> {
        let project = self.project(path).new_file(named).map_err(Problem::message)?;
        Ok(Box::new(project))
    }

    /// A file that is dropped on the window, or whose name is typed.
    pub(super) fn open(&self, path: &Path) -> Result<Opened, Problem> {
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ron")) {
            return Ok(Opened::Pipeline(Box::new(self.project(path))));
        }
        Ok(Opened::Input(self.input(&path.to_string_lossy()).map_err(problem)?))
    }

    /// A file or a sequence for an input.
    pub(super) fn input(&self, name: &str) -> Result<InputFile, Failure> {
        let (numbers, sources): (Vec<Option<u32>>, Vec<Source>) =
            sequence::Input::find(name, None)?.sources().into_iter().unzip();
        if let Some(first) = sources.first() {
            real_path(&first.path)?;
        }
        // A file that cannot be described is refused when it is read.
        let described = sources.first().and_then(|first| read_description(&Source::file(&first.path)).ok());
        let wake = self.wake.clone();
        let mut watch = FileWatch::new(move || wake.call());
        watch.extend(sources.iter().map(|source| source.path.clone()));
        let opener = self.clone();
        Ok(InputFile {
            name: name.to_owned(),
            numbers: numbers.into_iter().flatten().collect(),
            fps: self.fps,
            layers: described.map_or(Vec::new(), |described| described.layers),
            read: Box::new(move |input, index| opener.read(input, &sources, index).map_err(problem)),
            have_changed: Box::new(move || !watch.changed().is_empty()),
        })
    }

    /// A frame, as `render` reads it.
    fn read(&self, input: &GraphInput, sources: &[Source], index: usize) -> Result<InputData, Failure> {
        if is_camera(input) {
            let before = index.checked_sub(1).map(|before| read_camera_file(&sources[before])).transpose()?;
            let camera = read_camera_file(&sources[index])?.data(before.as_ref());
            return Ok(InputData::Block(camera.map_err(Failure::unreadable)?));
        }
        let picture = read_within(&sources[index], self.reading.options_for(self.budget, Some(input)))?;
        #[cfg(feature = "ocio")]
        let picture = match self.reading.config_space_of(input) {
            Some(space) => crate::ocio::to_linear(picture, space)?,
            None => picture,
        };
        let desc = match input.volume {
            true => volume(&input.name, picture.desc(), self.slices)?,
            false => picture.desc(),
        };
        Ok(InputData::Image(Box::new(picture), desc))
    }
}

fn problem(failure: Failure) -> Problem {
    match failure {
        Failure::Error { message, hint, .. } => Problem::Message { message, hint },
        other => Problem::message(other.message()),
    }
}
