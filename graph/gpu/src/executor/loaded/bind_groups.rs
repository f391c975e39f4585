//! The bind groups of a plan.

use std::sync::Arc;

use wgpu::{BindGroup, TextureFormat, TextureView};

use crate::executor::loaded::explicit_transitions::ExplicitTransitions;
use crate::pipelines::Built;

/// The bind groups of all passes, for one choice of host images.
pub(crate) struct BindGroups {
    /// Of all inputs, then of all outputs.
    pub(crate) views: Vec<TextureView>,
    /// The views that passes bind: the same, but of the depth alone where a texture has a stencil, too.
    pub(crate) bound_views: Vec<TextureView>,
    /// For each output the format in which it is drawn, if it is.
    pub(crate) drawn: Vec<Option<TextureFormat>>,
    /// For how many passes bind groups were made, and not taken from the last frame's.
    pub(crate) made: usize,
    pub(crate) passes: Vec<Arc<BoundPass>>,
    pub(crate) explicit_transitions: Arc<ExplicitTransitions>,
}

impl BindGroups {
    pub(crate) fn new(explicit_transitions: Arc<ExplicitTransitions>) -> Self {
        Self {
            views: Vec::new(),
            bound_views: Vec::new(),
            drawn: Vec::new(),
            made: 0,
            passes: Vec::new(),
            explicit_transitions,
        }
    }
}

/// The bind group of a pass; one for each ring index if the pass binds a history image, which rotates every frame.
#[derive(Clone)]
pub(crate) struct BoundPass {
    pub(crate) built: Built,
    pub(crate) groups: Arc<[BindGroup]>,
    /// The attachments of a draw, likewise: colors, then depth.
    pub(crate) attachments: Vec<Vec<TextureView>>,
}

impl BoundPass {
    pub(crate) fn group(&self, ring_index: usize) -> &BindGroup {
        &self.groups[ring_index % self.groups.len()]
    }

    pub(crate) fn attachments(&self, ring_index: usize) -> &[TextureView] {
        &self.attachments[ring_index % self.attachments.len()]
    }
}
