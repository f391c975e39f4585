//! The state of cross-fades.

use std::sync::Arc;

use wgpu::BindGroup;

use super::fade_skip_reason::FadeSkipReason;
use super::mix::FadeParts;
use super::running::ActivePlan;
use crate::executor::Residency;

/// How changes are faded, and the fade that goes on.
#[derive(Default)]
pub(super) struct Fade {
    /// Frames of each fade; 0 for none.
    pub(super) frames: u16,
    pub(super) fading: Option<Fading>,
    /// Why the last change was not faded.
    pub(super) missed: Option<FadeSkipReason>,
}

/// What a fade begins with, once the new plan is in.
pub(super) struct Beginning {
    pub(super) parts: FadeParts,
    /// The memory of the old plan.
    pub(super) left: Arc<Residency>,
}

/// An old plan that renders on beside the new one.
pub(super) struct Fading {
    pub(super) parts: FadeParts,
    pub(super) running: ActivePlan,
    /// What the old plan has left, until it is copied.
    pub(super) left: Option<Arc<Residency>>,
    /// Binds the pictures of both plans.
    pub(super) images: BindGroup,
    /// The number of the next frame, from 1, and the number of frames.
    pub(super) number: u16,
    pub(super) frames: u16,
}

impl Fade {
    /// That of another view: the same frames, and no change yet.
    pub(super) fn for_another(&self) -> Self {
        Self { frames: self.frames, ..Self::default() }
    }

    pub(super) fn goes_on(&self) -> bool {
        self.fading.is_some()
    }

    /// A change came in at once.
    pub(super) fn miss(&mut self, why: FadeSkipReason) {
        self.missed = (self.frames > 0).then_some(why);
    }

    /// A node of this graph has other values, in the old plan, too.
    pub(super) fn change(&mut self, node: usize, graph: u64) {
        if let Some(fading) = self.fading.as_mut().filter(|fading| fading.running.graph == graph) {
            fading.running.uniforms.change(node);
        }
    }
}
