//! What the viewer draws by itself: pictures, and the readings of probes and scopes.

pub(crate) mod device;
mod export;
mod grid;
mod picture;
mod probe;
mod readback;
mod screen;

pub use export::Copied;
pub use grid::{GRID, Grid};
pub use picture::{Drawn, Flags, Painter, Placement, Shown};
pub use probe::{Probe, Reading, TexelRequest};
pub use screen::{DRAWN, SDR_WHITE, Screen};
