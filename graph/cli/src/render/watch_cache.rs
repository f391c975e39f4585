//! The cache of `--watch` from one run to the next.

use std::collections::BTreeSet;
use std::path::PathBuf;

use afterimage::offline::Session;
use afterimage_gpu::InputImage;
use afterimage_graph::check::GraphInput;

use super::read::InputPicture;
use super::request::Request;

/// The device and the images of a run, for the next one with the same arguments.
pub(crate) struct WatchCache {
    /// The device with compiled pipelines and the images of the last frame.
    pub(super) session: Session,
    /// The images of a run with a single frame.
    pub(super) pictures: Option<CachedPictures>,
}

/// The images of a frame, and the inputs that they were read for.
pub(super) struct CachedPictures {
    pub(super) inputs: Vec<GraphInput>,
    pub(super) pictures: Vec<InputPicture>,
    /// The uploaded images.
    pub(super) images: Vec<InputImage>,
}

/// The relation of the frames of a run to those of the run before.
pub(super) struct Repetition {
    /// The uploaded images, if the only frame is that of the run before with other values.
    pub(super) uploaded: Option<Vec<InputImage>>,
    /// True if there may be a run after this one.
    pub(super) keeps: bool,
    /// The images of this run.
    pub(super) pictures: Option<CachedPictures>,
}

impl WatchCache {
    /// Forgets the images if one of these files is among theirs.
    pub(crate) fn forget(&mut self, changed: &BTreeSet<PathBuf>) {
        self.pictures.take_if(|cached| cached.pictures.iter().any(|input| changed.contains(&input.file)));
    }
}

impl CachedPictures {
    /// True if a run has the same images.
    pub(super) fn suit(&self, request: &Request<'_>) -> bool {
        let [job] = &*request.jobs else { return false };
        let known = self.pictures.iter().map(|input| (&input.name, &input.file));
        self.inputs == request.inputs && job.sources.iter().map(|(name, source)| (name, &source.path)).eq(known)
    }
}
