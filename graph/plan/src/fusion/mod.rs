//! Fusion: passes become one where that saves memory traffic or dispatches.

mod cell_reduce;
mod one_module;
mod pass_graph;
mod point;
mod row_downsample;
mod tile_cost;
mod tiles;
mod warp;

pub(crate) use row_downsample::{row_kernel, row_pass};

use crate::builder::PlanBuilder;
use crate::options::When;
use crate::request::PlanRequest;

/// Fuses passes, as far as the options ask for it and the device can run the result.
pub(crate) fn fusion(builder: &mut PlanBuilder, request: &PlanRequest<'_>) {
    let options = &request.options;
    let pays = |when: When| when == When::Always || when == When::WhereItPays && request.caps.tiles;
    if options.fuse {
        point::fuse_points(builder, &request.caps);
        warp::fuse_warps(builder, &request.caps);
    }
    if pays(options.row_downsample) {
        row_downsample::downsample_by_rows(builder, options.row_downsample == When::Always);
    }
    if pays(options.tile) {
        tiles::chain_in_tiles(builder, &request.caps, options.tile == When::Always);
    }
    if options.fuse {
        cell_reduce::join_cell_reductions(builder, &request.caps);
    }
}
