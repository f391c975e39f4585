//! The module that a pass runs.

use super::Plan;
use crate::image::ImageDesc;
use crate::node::ImageId;
use crate::shader::{Composed, Reading, ShaderError, compose_pass};

impl Plan {
    /// The module that a pass runs.
    pub fn compose(&self, pass: usize) -> Result<Composed, ShaderError> {
        let desc = |image: ImageId| -> ImageDesc { self.recording.image(image).desc };
        let reading = |image: ImageId| -> Reading { self.readings[image.0 as usize] };
        compose_pass(&self.recording.passes[pass], &desc, &reading, self.dialect(pass))
    }
}
