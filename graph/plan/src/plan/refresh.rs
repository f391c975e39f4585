//! The frames in which passes run.

use afterimage_graph::node::Resource;
use serde::Serialize;

/// The frames in which a pass runs. A pass with several runs in the frames of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Refresh {
    /// All frames.
    EachFrame,
    /// Frames whose number modulo `every` is `phase`, and those in which cached results are recomputed.
    Every { every: u32, phase: u32 },
    /// Frames before which its uniforms have changed: it evaluates a baked LUT.
    OnChange,
    /// Only frames in which cached results are recomputed: first frames, cuts, and those with changed uniforms.
    Once,
}

/// The results of a node that does not run in every frame. They are kept in between.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CachedResults {
    pub node: String,
    pub refresh: Refresh,
    /// The images and buffers. Empty if the node runs in every frame, because it keeps a state that changes.
    pub results: Vec<Resource>,
}

impl Refresh {
    /// The number of frames of which it has one; `None` if it does not depend on numbers of frames.
    pub fn every(self) -> Option<u32> {
        match self {
            Self::Every { every, .. } => Some(every),
            _ => None,
        }
    }

    /// Whether the result outlives the frame, and is recomputed when what it depends on has changed.
    pub fn is_cached(self) -> bool {
        matches!(self, Self::Every { .. } | Self::Once)
    }

    /// Whether a frame of that number is due after one of the number `before`. Numbers may have any steps: it is due,
    /// too, if a number between them is.
    pub fn is_due(self, number: u32, before: u32) -> bool {
        let Self::Every { every, phase } = self else { return self == Self::EachFrame };
        let [now, then] =
            [number, before].map(|number| (u64::from(number) + u64::from(every - phase)) / u64::from(every));
        now != then
    }
}
