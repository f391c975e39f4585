//! The host's blocks: what a frame gives, written where it differs from the frame before.

use super::Executor;
use super::frame::Frame;
use super::loaded::Loaded;
use crate::GpuError;
use crate::platform::{caught, scoped};

impl Executor {
    /// Writes the blocks of a frame that have changed.
    pub(super) fn write_blocks(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        let Loaded { plan, uniforms, blocks, .. } = loaded;
        for (planned, held) in plan.blocks.iter().zip(blocks) {
            let (port, wanted) = (&planned.name, planned.block);
            let given = frame.blocks.iter().find(|(name, _)| name == port).map(|(_, data)| *data);
            let data = given.ok_or_else(|| GpuError::MissingBlock { port: port.clone(), ty: wanted.name })?;
            if data.block() != wanted {
                let (port, given) = (port.clone(), data.block().name);
                return Err(GpuError::WrongBlock { port, given, wanted: wanted.name });
            }
            if held != data.bytes() {
                let write = || self.queue.write_buffer(uniforms, planned.offset, data.bytes());
                scoped(&self.compiler.device, "the blocks of a frame", || caught("the blocks of a frame", write))?;
                held.clear();
                held.extend_from_slice(data.bytes());
            }
        }
        Ok(())
    }
}
