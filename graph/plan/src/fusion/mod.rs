//! Fusion: passes become one where that saves memory traffic or dispatches.

mod cell_reduce;
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
use afterimage_base::caps::Caps;
use afterimage_graph::node::{KernelCall, Pass, Recording};

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

/// Whether passes of functions can be one module: it has no more uniform buffers than the device, and what is limited
/// to finite numbers where it is read is so alike. All textures of a module are, so the limits must be those of each
/// that may not be finite, and no narrower than what the others hold.
fn fit_one_module<'a>(passes: impl Iterator<Item = &'a Pass> + Clone, recording: &'a Recording, caps: &Caps) -> bool {
    let textures = || passes.clone().flat_map(|pass| &pass.kernels).flat_map(KernelCall::textures);
    let limits =
        textures().map(|image| recording.image(image)).filter(|image| !image.finite).map(|i| i.signedness).max();
    let is_kept = |limits| {
        textures().map(|image| recording.image(image)).all(|image| match image.finite {
            true => image.signedness <= limits,
            false => image.signedness == limits,
        })
    };
    let binds = Pass::joined_uniform_buffers(passes.clone()) <= caps.max_uniform_buffers as usize;
    binds && limits.is_none_or(is_kept)
}
