//! How many workgroups a pass dispatches.

use super::compose::steps_cover;
use super::rows::ROW_LANES;
use afterimage_base::image::Size;
use afterimage_graph::node::{ImageId, Pass, Recording, Work};

/// The workgroups of a pass of this recording, across, down and deep, if it does not draw.
pub fn workgroups(recording: &Recording, pass: &Pass) -> [u32; 3] {
    let size = |image: ImageId| recording.image(image).desc.size;
    let cover = |size: Size, [across, down]: [u32; 2]| [size.width.div_ceil(across), size.height.div_ceil(down), 1];
    match &pass.work {
        Work::Steps { result, .. } => cover(size(*result), steps_cover(size(*result))),
        Work::Tiled(tiling) => {
            let last = tiling.stages.last().expect("a tiling has stages").size;
            cover(last, [tiling.tile; 2])
        }
        Work::Rows(rows) => cover(size(rows.result), [ROW_LANES - 2, rows.rows]),
        Work::Cells(cells) => [cells.coarsest[0], cells.coarsest[1], 1],
        Work::Entry(call) => call.groups,
    }
}
