//! The tiers of a pipeline that changes its tier by itself.

use afterimage_graph::check::Graph;

use crate::governor::{Governor, TierChange};

/// The tiers of a pipeline, and the governor that chooses one.
pub(super) struct Governed {
    pub(super) governor: Governor,
    pub(super) graphs: Vec<Graph>,
    pub(super) source: TimeSource,
    /// Frames up to this one had another tier, or their times have been taken.
    pub(super) taken: u64,
    /// Seconds since the last frame whose time was taken.
    pub(super) seconds: f64,
    pub(super) last_change: Option<TierChange>,
}

/// The source of the times of frames.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeSource {
    /// The passes are timed.
    Passes,
    /// The device has no timestamps, and the host has reported no time.
    None,
    Host,
}

impl Governed {
    pub(super) fn present_graph(&self) -> Graph {
        self.graphs[self.governor.tier()].clone()
    }

    /// Takes the time of a frame, unless it had another tier or was taken before.
    pub(super) fn take(&mut self, frame: u64, ms: f64) -> Option<TierChange> {
        if frame <= self.taken {
            return None;
        }
        self.taken = frame;
        self.governor.frame(self.governor.tier(), ms, std::mem::take(&mut self.seconds))
    }
}
