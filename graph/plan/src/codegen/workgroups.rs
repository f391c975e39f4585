//! How many workgroups a pass dispatches.

use super::functions::functions_cover;
use super::row_downsample::rows_cover;
use crate::plan::PlannedImage;
use afterimage_base::image::Size;
use afterimage_graph::node::{KernelCall, Pass, PassKind};

/// The workgroups of a pass, across, down and deep, if it does not draw.
pub(super) fn workgroups(pass: &Pass, images: &[PlannedImage]) -> [u32; 3] {
    let result = || images[pass.results[0].image.0 as usize].desc.size;
    let cover = |size: Size, [across, down]: [u32; 2]| [size.width.div_ceil(across), size.height.div_ceil(down), 1];
    let mut textures = pass.kernels.iter().flat_map(KernelCall::textures);
    let sanitizes = textures.any(|image| images[image.0 as usize].sample_mode.sanitizes());
    match &pass.kind {
        PassKind::Point | PassKind::Gather => cover(result(), functions_cover(pass, result(), sanitizes)),
        PassKind::RowDownsample(rows) => cover(result(), rows_cover(rows)),
        PassKind::CellReduce(cells) => [cells.coarsest[0], cells.coarsest[1], 1],
        PassKind::Workgroup(invocations) => cover(result(), *invocations),
        PassKind::Compute => pass.kernels[0].workgroups.unwrap_or([1; 3]),
        PassKind::Drawing(_) => [1; 3],
    }
}
