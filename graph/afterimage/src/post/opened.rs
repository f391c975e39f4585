//! The files of a pipeline.

use crate::files::Stamps;
use crate::snapshot::Snapshot;
use crate::source::Source;

/// The files of a pipeline, and its tier.
pub(super) struct Opened {
    /// The source of the files, if the pipeline reads them by itself.
    pub(super) source: Option<Source>,
    /// The tier that the host has chosen.
    pub(super) tier: Option<String>,
    /// The files that were read last without an error.
    pub(super) snapshot: Snapshot,
    /// The files that were read last, also with an error.
    pub(super) stamps: Stamps,
}
