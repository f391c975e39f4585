//! Checks of a recording against the [limits](crate::limits) of a plan.

use crate::error::PlanError;
use crate::limits::{MAX_COMPUTED, MAX_COMPUTED_BYTES, MAX_PASSES, MAX_TABLE_BYTES};
use afterimage_graph::node::{BufferLife, Origin, Recording};

/// The tables that have been counted.
#[derive(Default)]
pub(crate) struct RecordingLimits {
    images: usize,
    buffers: usize,
    bytes: u64,
}

impl RecordingLimits {
    /// Counts what has been recorded since the last call, the last of it by `node`.
    pub(crate) fn check(&mut self, node: &str, recording: &Recording) -> Result<(), PlanError> {
        let images = recording.images[self.images..].iter().map(|image| match &image.origin {
            Origin::Constant(bytes) => bytes.len() as u64,
            _ => 0,
        });
        let buffers = recording.buffers[self.buffers..].iter().map(|buffer| match &buffer.life {
            BufferLife::Constant(bytes) => bytes.len() as u64,
            _ => 0,
        });
        self.bytes += images.chain(buffers).sum::<u64>();
        (self.images, self.buffers) = (recording.images.len(), recording.buffers.len());
        if recording.passes.len() > MAX_PASSES {
            return Err(PlanError::TooManyPasses(node.to_owned()));
        }
        if recording.computed.len() > MAX_COMPUTED {
            return Err(PlanError::TooManyTables(node.to_owned()));
        }
        let computed = recording.computed.values().map(|bytes| bytes.len() as u64).sum();
        check_bytes(node, computed, MAX_COMPUTED_BYTES)?;
        check_bytes(node, self.bytes, MAX_TABLE_BYTES)
    }
}

fn check_bytes(node: &str, bytes: u64, limit: u64) -> Result<(), PlanError> {
    if bytes > limit { Err(PlanError::TooLargeTables { node: node.to_owned(), bytes, limit }) } else { Ok(()) }
}
