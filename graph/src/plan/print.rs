//! Plans as text.

use super::{Fused, LeftOut, Plan, Stage};
use super::names::Names;
use crate::node::{ImageId, Resource, Work};

/// Bytes in MiB with one digit; small numbers with three.
pub(super) fn mebibytes(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if bytes == 0 || mebibytes >= 0.1 { format!("{mebibytes:.1} MiB") } else { format!("{mebibytes:.3} MiB") }
}

impl Plan {
    /// Bytes that all passes read and write in one frame, each image once a pass; what caches spare is not counted.
    pub fn bytes_moved(&self) -> u64 {
        (0..self.recording.passes.len()).map(|pass| self.bytes_moved_by(pass)).sum()
    }

    /// Bytes that one pass reads and writes.
    pub fn bytes_moved_by(&self, pass: usize) -> u64 {
        let pass = &self.recording.passes[pass];
        let touched = pass.reads().into_iter().chain(pass.writes());
        touched.map(|resource| self.bytes_of(resource)).sum()
    }

    fn bytes_of(&self, resource: Resource) -> u64 {
        match resource {
            Resource::Image(image) => self.recording.image(image).desc.bytes(),
            Resource::Buffer(_) => 0,
        }
    }
}
