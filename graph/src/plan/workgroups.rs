//! How many workgroups a pass has when it is dispatched.

use crate::image::Size;
use crate::node::{ImageId, Pass, Recording, Work};
use crate::shader::{STEPS_LANES, TILE_LANES, steps_cover};

/// The workgroups of a dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workgroups {
    /// Across, down and deep.
    pub count: [u32; 3],
    /// Invocations of each.
    pub lanes: u32,
}

impl Recording {
    /// The workgroups of a pass of this recording, if it does not draw.
    pub fn workgroups(&self, pass: &Pass) -> Workgroups {
        let size = |image: ImageId| self.image(image).desc.size;
        let cover = |size: Size, [across, down]: [u32; 2]| [size.width.div_ceil(across), size.height.div_ceil(down), 1];
        let (count, lanes) = match &pass.work {
            Work::Steps { result, .. } => (cover(size(*result), steps_cover(size(*result))), STEPS_LANES),
            Work::Tiled(tiling) => {
                let last = tiling.stages.last().expect("a tiling has stages").size;
                (cover(last, [tiling.tile; 2]), TILE_LANES)
            }
            Work::Rows(rows) => (cover(size(rows.result), [rows.lanes - 2, rows.rows]), rows.lanes),
            Work::Cells(cells) => ([cells.coarsest[0], cells.coarsest[1], 1], cells.workgroup()),
            Work::Entry(call) => (call.groups, call.shader.lanes(call.entry)),
        };
        Workgroups { count, lanes }
    }
}
