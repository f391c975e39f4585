//! What `--watch` keeps from one run for the next.

use std::collections::BTreeSet;
use std::path::PathBuf;

use afterimage_graph::check::GraphInput;

use super::read::InputPicture;
use super::request::Request;
use crate::device::CachedSession;

/// What a run leaves for the next one with the same arguments.
pub(crate) struct Kept {
    /// The device with compiled pipelines and the images of the last frame.
    pub(super) session: CachedSession,
    /// What a single picture was made from.
    pub(super) pictures: Option<KeptPictures>,
}

/// The images that a picture was made from, and the inputs that they were read for.
pub(super) struct KeptPictures {
    pub(super) inputs: Vec<GraphInput>,
    pub(super) pictures: Vec<InputPicture>,
}

/// How the frames of a run follow those of the run before.
pub(super) struct Repetition {
    /// Whether the only frame is that of the run before with other values.
    pub(super) again: bool,
    /// Whether there may be a run after this one.
    pub(super) keeps: bool,
    /// What this run leaves.
    pub(super) pictures: Option<KeptPictures>,
}

impl Kept {
    /// Forgets the images if one of these files is among theirs.
    pub(crate) fn forget(&mut self, changed: &BTreeSet<PathBuf>) {
        self.pictures.take_if(|kept| kept.pictures.iter().any(|input| changed.contains(&input.file)));
    }
}

impl KeptPictures {
    /// Whether a run has the same images.
    pub(super) fn suit(&self, request: &Request<'_>) -> bool {
        let [job] = &*request.jobs else { return false };
        let known = self.pictures.iter().map(|input| (&input.name, &input.file));
        self.inputs == request.inputs && job.sources.iter().map(|(name, source)| (name, &source.path)).eq(known)
    }
}
