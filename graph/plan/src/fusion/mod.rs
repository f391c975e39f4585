//! Fusion: passes become one where that saves memory traffic or dispatches.

mod module_limits;
mod neighbors;
mod pass_graph;
mod point;
mod row_downsample;
mod warp;

pub(crate) use neighbors::{Neighbors, square_kernel};
pub(crate) use row_downsample::{row_kernel, row_pass};

use crate::builder::PlanBuilder;
use crate::options::When;
use crate::request::PlanRequest;
use row_downsample::RowDownsampling;

/// Fuses passes, as far as the options ask for it and the device can run the result.
pub(crate) fn fusion(builder: &mut PlanBuilder, request: &PlanRequest<'_>) {
    let (options, caps) = (&request.options, &request.caps);
    let by_rows = match options.row_downsample {
        When::Always => Some(RowDownsampling { always: true }),
        When::WhereItPays if options.fuse && caps.fast_workgroup_memory => Some(RowDownsampling { always: false }),
        When::WhereItPays | When::Never => None,
    };
    if options.fuse {
        // A halving by rows costs less than its readers would save by taking it over.
        point::fuse_points(builder, caps, &|graph, recording, pass| {
            by_rows.is_some_and(|by_rows| by_rows.takes(graph, recording, pass))
        });
        warp::fuse_warps(builder, caps);
    }
    let makes_again = by_rows.is_some_and(|by_rows| by_rows.replace_halvings(builder, caps));
    // What the halvings make themselves, others read pixel by pixel.
    if options.fuse && makes_again {
        point::fuse_points(builder, caps, &|_, _, _| false);
    }
}
