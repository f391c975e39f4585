//! The bind groups for one choice of images of the host.

use std::sync::Arc;

use wgpu::{BindGroup, TextureFormat, TextureUses, TextureView};

use super::explicit_transitions::ExplicitTransitions;
use super::residency::Residency;
use crate::pipelines::Built;

/// The bind groups for one choice of host images.
pub(super) struct HostSet {
    pub(super) views: Vec<TextureView>,
    /// For each output the format in which it is drawn, if it is.
    pub(super) drawn: Vec<Option<TextureFormat>>,
    /// How many runs are its own, and not those of the set before.
    pub(super) made: usize,
    pub(super) runs: Vec<Arc<Run>>,
    pub(super) explicit_transitions: Arc<ExplicitTransitions>,
}

impl HostSet {
    /// The explicit transitions before a pass: views of images, and their new states.
    pub(super) fn transitions_before<'a>(
        &'a self,
        residency: &'a Residency,
        pass: usize,
        ring_index: usize,
    ) -> impl ExactSizeIterator<Item = (&'a TextureView, TextureUses)> {
        self.explicit_transitions.before(pass, residency, (&self.views, ring_index))
    }
}

/// The bind groups of a pass: one, or one for each ring index if it names images in rings.
pub(super) struct Run {
    pub(super) built: Built,
    pub(super) groups: Arc<[BindGroup]>,
    /// The attachments of a draw, likewise: colors, then depth.
    pub(super) attachments: Vec<Vec<TextureView>>,
}

impl Run {
    pub(super) fn group(&self, ring_index: usize) -> &BindGroup {
        &self.groups[ring_index % self.groups.len()]
    }

    pub(super) fn attachments(&self, ring_index: usize) -> &[TextureView] {
        &self.attachments[ring_index % self.attachments.len()]
    }
}
