//! Results that are held while their nodes do not run.

use afterimage_graph::node::Resource;
use serde::Serialize;

/// The frames in which a node runs, beside those in which all begins anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Turn {
    /// No others.
    First,
    /// One of `every` frames: those whose numbers leave `phase` as a rest.
    OneOf { every: u32, phase: u32 },
}

/// The results of a node that runs in one of several frames. They are kept in between.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Held {
    pub node: String,
    pub turn: Turn,
    /// What it makes; nothing if it keeps a state of its own, and therefore runs in every frame, unless the state stays
    /// as it is.
    pub results: Vec<Resource>,
}

impl Turn {
    /// Of how many frames it is one; none if only those count in which all begins anew.
    pub fn every(self) -> Option<u32> {
        match self {
            Self::First => None,
            Self::OneOf { every, .. } => Some(every),
        }
    }

    /// Whether a frame of that number is one of them, or one lies between it and that of the number `before`: numbers
    /// may have any steps.
    pub fn is_due(self, number: u32, before: u32) -> bool {
        let Self::OneOf { every, phase } = self else { return false };
        let [now, then] =
            [number, before].map(|number| (u64::from(number) + u64::from(every - phase)) / u64::from(every));
        now != then
    }
}
