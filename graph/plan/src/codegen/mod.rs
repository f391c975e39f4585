//! Code generation: what a device needs to run the passes. Workgroups and uniforms are part of the plan; the module of
//! a pass, with entry points and bindings, is made when it is asked for.

mod compute;
mod drawing;
mod functions;
mod in_workgroup;
mod module;
mod row_downsample;
mod uniforms;
mod workgroups;
mod writer;

use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{ImageId, Pass, PassKind};
use afterimage_wgsl::{SampleMode, ShaderError};

use crate::plan::{Plan, PlannedImage, PlannedPass, ScheduledPass};
use compute::compose_compute;
use drawing::compose_drawing;
use functions::compose_functions;
use in_workgroup::compose_in_workgroup;
use module::PassCode;
use row_downsample::compose_row_downsample;

pub(crate) use functions::functions_cover;
pub use module::{CodeOptions, Composed, Draw, Slot, SlotKind};
pub use uniforms::UNIFORM_ALIGNMENT;
pub(crate) use uniforms::blocks;
pub(crate) use workgroups::rows_of_workgroup;

/// The passes with their workgroups and uniforms.
pub fn codegen(passes: Vec<ScheduledPass>, images: &[PlannedImage]) -> Vec<PlannedPass> {
    let blocks = uniforms::uniform_blocks(&passes, images);
    let mut planned = Vec::with_capacity(passes.len());
    for (scheduled, uniform) in passes.into_iter().zip(blocks) {
        let ScheduledPass { pass, stage, stores, recorded, refresh } = scheduled;
        let workgroups = workgroups::workgroups(&pass, images);
        planned.push(PlannedPass { pass, stage, stores, recorded, refresh, workgroups, uniform });
    }
    planned
}

/// The module of a pass. `desc_of` describes its images; `sample_mode_of` states how each is sampled, and the strictest
/// of a pass's textures holds for all of its taps.
///
/// # Errors
/// Errors in the shaders, at the author's line.
pub fn compose_pass(
    pass: &Pass,
    desc_of: &dyn Fn(ImageId) -> ImageDesc,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    options: CodeOptions,
) -> Result<Composed, ShaderError> {
    let code = PassCode { pass, desc_of, sample_mode_of, options };
    match &pass.kind {
        PassKind::Point | PassKind::Gather => compose_functions(&code),
        PassKind::RowDownsample(rows) => compose_row_downsample(&code, rows),
        PassKind::Workgroup(invocations) => compose_in_workgroup(&code, *invocations),
        PassKind::Compute => compose_compute(&code),
        PassKind::Drawing(drawing) => compose_drawing(&code, drawing),
    }
}

impl Plan {
    /// The module that a pass runs. Whether its result has an origin follows from the plan.
    ///
    /// # Errors
    /// What is wrong with a shader, at the author's line.
    pub fn compose(&self, pass: usize, options: CodeOptions) -> Result<Composed, ShaderError> {
        let pass = &self.passes[pass].pass;
        let options = CodeOptions { has_origin: self.has_origin(pass), ..options };
        compose_pass(pass, &|image| self.image(image).desc, &|image| self.image(image).sample_mode, options)
    }
}
