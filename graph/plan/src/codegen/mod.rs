//! Shader code of a pass: its module with entry points and bindings, and the workgroups that it dispatches.

mod cells;
mod compose;
mod features;
mod rows;
mod tiles;
mod workgroups;

use afterimage_base::image::ImageDesc;
use afterimage_graph::node::ImageId;
use afterimage_wgsl::{SampleMode, ShaderError};

use crate::Plan;

pub use cells::CELLS_LANES;
pub use compose::{Composed, Slot, SlotKind, compose_pass};
pub use features::Ignored;
pub use rows::ROW_LANES;
pub use workgroups::workgroups;

impl Plan {
    /// The module that a pass runs.
    pub fn compose(&self, pass: usize) -> Result<Composed, ShaderError> {
        let desc = |image: ImageId| -> ImageDesc { self.recording.image(image).desc };
        let reading = |image: ImageId| -> SampleMode { self.sample_modes[image.0 as usize] };
        compose_pass(&self.recording.passes[pass], &desc, &reading, self.features(pass))
    }
}
