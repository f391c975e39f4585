//! The tiers of a pipeline that changes its tier by itself.

use afterimage_graph::check::Graph;

use crate::error::Error;
use crate::governor::{Governor, TierChange, TierLimits};
use crate::snapshot::Snapshot;

/// The tiers of a pipeline, and the governor that chooses one.
pub(super) struct Governed {
    pub(super) governor: Governor,
    /// Those of all tiers that the host has named, also of those that the governor may not choose.
    graphs: Vec<(String, Graph)>,
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
    /// Begins with the claims of the pipeline. Frames up to `taken` have another tier.
    pub(super) fn new(snapshot: &Snapshot, limits: TierLimits, tiers: &[&str], taken: u64) -> Result<Self, Error> {
        let graph = |tier: &&str| Ok(((*tier).to_owned(), snapshot.graph(Some(tier))?));
        let graphs = tiers.iter().map(graph).collect::<Result<Vec<(String, Graph)>, Error>>()?;
        let governor = snapshot.governor(limits, tiers);
        Ok(Self { governor, graphs, source: TimeSource::Passes, taken, seconds: 0.0, last_change: None })
    }

    /// Takes the pipeline's files again. What is known about its tiers stays, unless others may be chosen now.
    pub(super) fn reload(&mut self, snapshot: &Snapshot, taken: u64) -> Result<(), Error> {
        let names: Vec<&str> = self.graphs.iter().map(|(name, _)| name.as_str()).collect();
        let new = Self::new(snapshot, self.governor.limits().clone(), &names, taken)?;
        match new.governor.names().eq(self.governor.names()) {
            true => self.graphs = new.graphs,
            false => *self = Self { source: self.source, ..new },
        }
        Ok(())
    }

    pub(super) fn present_graph(&self) -> Graph {
        let present = self.graphs.iter().find(|(name, _)| name == self.governor.name());
        present.expect("each tier of the governor has a graph").1.clone()
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
