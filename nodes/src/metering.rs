//! Shared by the metering kinds.

use afterimage_graph::prelude::*;

/// EV100 of a luminance of 1 cd/m2: log2(100 / 12.5), a reflected-light meter with K = 12.5 (ISO 2720).
pub(crate) const EV100_OF_LUMINANCE: f32 = 3.0;

/// The target of the previous frame, in stops. Between two frames the target is taken to move on a straight line.
pub(crate) fn wanted_before(pass: &mut Recorder<'_>) -> BufferId {
    pass.add_buffer("wanted_before", 4, BufferLife::Persistent)
}

choices! {
    /// How an exposure approaches its target.
    pub enum Adaptation {
        /// By the same share of the remaining distance per unit of time: fast at first, then slower. Rates in 1/s.
        Exponential,
        /// At a constant speed. Rates in stops per second.
        Linear,
    }
}
