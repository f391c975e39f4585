//! Passes of a plan.

use std::collections::BTreeSet;

use afterimage_graph::node::Pass;
use serde::Serialize;

/// A pass in its place in the order of execution.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledPass {
    /// The kernels and what they read and write.
    pub pass: Pass,
    /// Dispatch or draw.
    pub stage: Stage,
    /// For each attachment of a drawing pass, colors before depth, whether something reads it later.
    pub stores: Vec<bool>,
    /// Its place in the order of recording, which states what each read must see.
    pub recorded: usize,
    /// The frames in which it runs: those of each element. Never empty.
    pub refresh: BTreeSet<Refresh>,
}

/// A pass with everything that a device needs to run it, but its shader text: see
/// [`compose`](crate::Plan::compose).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedPass {
    /// The kernels and what they read and write.
    #[serde(flatten)]
    pub pass: Pass,
    /// Dispatch or draw.
    pub stage: Stage,
    /// For each attachment of a drawing pass, colors before depth, whether something reads it later.
    pub stores: Vec<bool>,
    /// Its place in the order of recording, which states what each read must see.
    pub recorded: usize,
    /// The frames in which it runs: those of each element. Never empty.
    #[serde(skip_serializing_if = "runs_each_frame")]
    pub refresh: BTreeSet<Refresh>,
    /// Workgroups across, down and deep, if it does not draw.
    pub workgroups: [u32; 3],
    #[serde(skip)]
    pub uniform: UniformBlock,
}

fn runs_each_frame(refresh: &BTreeSet<Refresh>) -> bool {
    refresh.contains(&Refresh::EachFrame)
}

/// The uniform of a pass, and where it lies in the one uniform buffer of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UniformBlock {
    /// Offset of the bytes in the buffer.
    pub offset: u64,
    /// The uniforms of all kernels; empty if they have none.
    pub bytes: Vec<u8>,
    /// Offset of the size of the result in the buffer.
    pub extent_offset: u64,
    /// The size of the first image that the pass writes, in texels, and its first texel in the host's image.
    pub extent: [f32; 4],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Stage {
    Compute,
    /// A full-screen triangle.
    Fragment,
    /// A drawing pass: its own geometry, or what the host records.
    Drawing,
}

impl PlannedPass {
    /// The pass without what code generation has added.
    pub fn scheduled(&self) -> ScheduledPass {
        let Self { pass, stage, stores, recorded, refresh, .. } = self.clone();
        ScheduledPass { pass, stage, stores, recorded, refresh }
    }
}

/// The frames in which a pass runs. A pass with several runs in the frames of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Refresh {
    EachFrame,
    /// Frames whose number modulo `every` is `phase`, and those in which cached results are recomputed.
    Every {
        every: u32,
        phase: u32,
    },
    /// Frames before which its uniforms have changed: it evaluates a baked LUT.
    OnChange,
    /// Only frames in which cached results are recomputed: first frames, cuts, and those with changed uniforms.
    Once,
}

impl Refresh {
    /// The number of frames of which it has one; `None` if it does not depend on numbers of frames.
    pub fn every(self) -> Option<u32> {
        match self {
            Self::Every { every, .. } => Some(every),
            _ => None,
        }
    }

    /// Returns whether a frame of that number is due after one of the number `before`, with any step between them: it
    /// is due, too, if a number between them is.
    pub fn is_due(self, number: u32, before: u32) -> bool {
        let Self::Every { every, phase } = self else { return self == Self::EachFrame };
        let [now, then] =
            [number, before].map(|number| (u64::from(number) + u64::from(every - phase)) / u64::from(every));
        now != then
    }
}
