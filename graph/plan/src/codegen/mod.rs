//! Code generation: what a device needs to run the passes. Workgroups and uniforms are part of the plan; the module of
//! a pass, with entry points and bindings, is made when it is asked for.

mod cell_reduce;
mod compose;
mod compute;
mod drawing;
mod features;
mod functions;
mod in_workgroup;
mod module;
mod row_downsample;
mod uniforms;
mod workgroups;
mod writer;

use afterimage_wgsl::ShaderError;

use crate::options::Options;
use crate::plan::{Plan, PlannedImage, PlannedPass, ScheduledPass};

pub use compose::compose_pass;
pub(crate) use functions::functions_cover;
pub use module::{CodeOptions, Composed, Draw, Slot, SlotKind};
pub use uniforms::UNIFORM_ALIGNMENT;
pub(crate) use uniforms::blocks;

/// The passes with their shader features, workgroups and uniforms.
pub fn codegen(passes: Vec<ScheduledPass>, images: &[PlannedImage], options: &Options) -> Vec<PlannedPass> {
    let blocks = uniforms::uniform_blocks(&passes, images);
    let planned = |(scheduled, uniform): (ScheduledPass, _)| {
        let ScheduledPass { pass, stage, stores, recorded } = scheduled;
        let features = features::features(&pass, images, options);
        let workgroups = workgroups::workgroups(&pass, images);
        PlannedPass { pass, stage, stores, recorded, features, workgroups, uniform }
    };
    passes.into_iter().zip(blocks).map(planned).collect()
}

impl Plan {
    /// The module that a pass runs; with `immediates` it takes the frame's time from immediates and not from a uniform
    /// buffer.
    ///
    /// # Errors
    /// What is wrong with a shader, at the author's line.
    pub fn compose(&self, pass: usize, immediates: bool) -> Result<Composed, ShaderError> {
        let PlannedPass { pass, features, .. } = &self.passes[pass];
        let in_rectangle = self.is_in_rectangle(pass);
        let options = CodeOptions { features: *features, immediates, in_rectangle };
        compose_pass(pass, &|image| self.image(image).desc, &|image| self.image(image).sample_mode, options)
    }
}
