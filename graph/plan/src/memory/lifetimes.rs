//! Lifetimes of images.

use std::collections::BTreeSet;

use crate::plan::{Lifetime, PlannedImage};
use crate::schedule::Schedule;
use afterimage_graph::node::{ImageId, Resource};

/// Sets the lifetime of each image that a pass uses. Images in `kept` outlive the frame or leave it.
pub(super) fn set_lifetimes(images: &mut [PlannedImage], schedule: &Schedule, kept: &BTreeSet<ImageId>) {
    for (batch, passes) in schedule.batches.iter().enumerate() {
        for scheduled in &schedule.passes[passes.clone()] {
            for image in scheduled.pass.resources().filter_map(Resource::image) {
                let lifetime = &mut images[image.0 as usize].lifetime;
                lifetime.get_or_insert(Lifetime { first: batch, last: batch }).last = batch;
            }
        }
    }
    for image in kept {
        if let Some(lifetime) = &mut images[image.0 as usize].lifetime {
            lifetime.last = schedule.batches.len();
        }
    }
}
