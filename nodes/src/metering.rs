//! What the metering kinds share.

use afterimage_graph::prelude::*;

/// EV100 of a luminance of 1 cd/m2: log2(100 / 12.5), a reflected-light meter with K = 12.5 (ISO 2720).
pub(crate) const EV100_OF_LUMINANCE: f32 = 3.0;

/// The stops that were wanted in the frame before: between two frames the aim is taken to move in a straight line.
pub(crate) fn wanted_before(pass: &mut Recorder<'_>) -> BufferId {
    pass.add_buffer("wanted_before", 4, BufferLife::Persistent)
}

choices! {
    /// How an exposure follows what is asked of it.
    pub enum Adaptation {
        /// By the same share of what is left in each moment: fast at first, then slower; rates in 1/s.
        Exponential,
        /// At a constant speed; rates in stops per second.
        Linear,
    }
}
