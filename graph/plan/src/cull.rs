//! Culling: a node may record more passes than its present readers need.

use std::collections::BTreeSet;

use crate::builder::PlanBuilder;
use afterimage_graph::node::{BufferLife, Resource};

/// Removes passes that write nothing which is read later, remembered or shown.
pub(crate) fn cull(builder: &mut PlanBuilder) {
    let kept = builder.kept();
    let buffers = &builder.recording.buffers;
    let mut read: BTreeSet<Resource> = BTreeSet::new();
    let mut needed = Vec::new();
    for pass in builder.recording.passes.iter().rev() {
        let stays = |resource: &Resource| match resource {
            Resource::Image(image) => kept.contains(image),
            Resource::Buffer(buffer) => buffers[buffer.0 as usize].life == BufferLife::Persistent,
        };
        let matters = pass.writes().iter().any(|resource| read.contains(resource) || stays(resource));
        needed.push(matters);
        if matters {
            read.extend(pass.reads());
        }
    }
    builder.recording.passes.retain(|_| needed.pop().unwrap_or(true));
}
