//! Workgroup counts of passes.

use super::functions::functions_cover;
use super::row_downsample::rows_cover;
use crate::plan::PlannedImage;
use afterimage_base::image::Size;
use afterimage_graph::node::{KernelCall, Pass, PassKind};

/// The workgroups of a pass, across, down and deep, if it does not draw.
pub(super) fn workgroups(pass: &Pass, images: &[PlannedImage]) -> [u32; 3] {
    let result = || images[pass.results[0].image.0 as usize].desc.size;
    let cover = |size: Size, [across, down]: [u32; 2]| [size.width.div_ceil(across), size.height.div_ceil(down), 1];
    match (&pass.kind, texels(pass, images)) {
        (_, Some(texels)) => cover(result(), texels),
        (PassKind::Compute, _) => pass.kernels[0].workgroups.unwrap_or([1; 3]),
        _ => [1; 3],
    }
}

/// Rows of the result that a workgroup makes; `None` if the kernel has an order of its own.
pub(crate) fn rows_of_workgroup(pass: &Pass, images: &[PlannedImage]) -> Option<u32> {
    texels(pass, images).map(|[_, rows]| rows)
}

/// Texels of the result that a workgroup makes, across and down.
fn texels(pass: &Pass, images: &[PlannedImage]) -> Option<[u32; 2]> {
    let mut textures = pass.kernels.iter().flat_map(KernelCall::textures);
    let sanitizes = textures.any(|image| images[image.0 as usize].sample_mode.sanitizes());
    match &pass.kind {
        PassKind::Point | PassKind::Gather => {
            let size = images[pass.results[0].image.0 as usize].desc.size;
            Some(functions_cover(pass, size, sanitizes))
        }
        PassKind::RowDownsample(rows) => Some(rows_cover(rows)),
        PassKind::Workgroup(invocations) => Some(*invocations),
        PassKind::Compute | PassKind::Drawing(_) => None,
    }
}
