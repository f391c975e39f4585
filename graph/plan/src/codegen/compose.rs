//! One function per kind of pass.

use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{ImageId, Pass, PassKind};
use afterimage_wgsl::{SampleMode, ShaderError};

use super::compute::compose_compute;
use super::drawing::compose_drawing;
use super::functions::compose_functions;
use super::in_workgroup::compose_in_workgroup;
use super::module::{CodeOptions, Composed, PassCode};
use super::row_downsample::compose_row_downsample;

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
