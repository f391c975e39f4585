//! Results that are held while their nodes do not run.

use afterimage_graph::node::Resource;
use serde::Serialize;

/// The frames in which a node runs, beside those in which all begins anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Turn {
    /// One of N frames, or [`Turn::FIRST`].
    pub every: u32,
    /// The rest that the numbers of these frames leave.
    pub phase: u32,
}

/// The results of a node that runs in one of several frames. They are kept in between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    pub node: String,
    pub turn: Turn,
    /// What it makes; nothing if it keeps a state of its own, and therefore runs in every frame, unless the state stays
    /// as it is.
    pub results: Vec<Resource>,
}

impl Turn {
    /// For `every`: only where all begins anew.
    pub const FIRST: u32 = u32::MAX;

    /// Whether a frame of that number is one of them, or one lies between it and that of the number `before`: numbers
    /// may have any steps.
    pub fn is_due(&self, number: u32, before: u32) -> bool {
        let turn = |number: u32| (u64::from(number) + u64::from(self.every - self.phase)) / u64::from(self.every);
        self.every != Self::FIRST && turn(number) != turn(before)
    }
}
