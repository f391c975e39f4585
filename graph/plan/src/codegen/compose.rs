//! The module of a pass: its kernels with their imports, bindings and an entry point.

use super::cell_reduce::compose_cell_reduce;
use super::compute::compose_compute;
use super::functions::compose_functions;
use super::module::Composed;
use super::row_downsample::compose_row_downsample;
use super::tiles::compose_tiled_chain;
use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{ImageId, Pass, PassKind};
use afterimage_wgsl::{SampleMode, ShaderError, ShaderFeatures};

/// The module of a pass, for images of these descriptions and sample modes.
///
/// # Errors
/// What is wrong with a shader, at the author's line.
pub fn compose_pass(
    pass: &Pass,
    desc_of: &dyn Fn(ImageId) -> ImageDesc,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let format_of = |image| desc_of(image).format;
    let result = || pass.results.first().expect("functions have a result").image;
    match &pass.kind {
        PassKind::Point | PassKind::Gather => {
            compose_functions(pass, (result(), desc_of(result())), sample_mode_of, features)
        }
        PassKind::TiledChain(chain) => compose_tiled_chain(pass, chain, &format_of, sample_mode_of, features),
        PassKind::RowDownsample(rows) => {
            compose_row_downsample(pass, rows, (result(), format_of(result())), sample_mode_of, features)
        }
        PassKind::CellReduce(cells) => compose_cell_reduce(pass, cells, &format_of, sample_mode_of, features),
        PassKind::Compute => compose_compute(&pass.kernels[0], &format_of, sample_mode_of, features),
    }
}
