//! Drawing the last frame again.

use wgpu::{Buffer, CommandEncoder};

use crate::executor::loaded::Loaded;
use crate::executor::loaded::due_passes::WrittenBuffer;
use crate::frame_constants::FrameConstants;

impl Loaded {
    /// Records, before a frame, a copy of the state to draw the frame again from.
    pub(crate) fn save_state(&self, encoder: &mut CommandEncoder) {
        for (own, saved) in self.saved_state() {
            encoder.copy_buffer_to_buffer(&self.residency.buffers[own.index], 0, saved, 0, None);
        }
    }

    /// Restores, before the last frame is drawn again, the state that the passes write which run.
    pub(crate) fn restore_state(&self, encoder: &mut CommandEncoder) {
        for (own, saved) in self.saved_state().filter(|(own, _)| self.due.writes(own)) {
            encoder.copy_buffer_to_buffer(saved, 0, &self.residency.buffers[own.index], 0, None);
        }
    }

    fn saved_state(&self) -> impl Iterator<Item = (&WrittenBuffer, &Buffer)> {
        self.redraw.iter().flat_map(|redraw| self.persistent.iter().zip(&redraw.state))
    }

    /// The constants of the last frame, if it can be drawn again from the state before it.
    pub(crate) fn last_constants(&self) -> Option<FrameConstants> {
        self.redraw.as_ref()?.constants
    }

    /// Sets the constants of the last frame; `None` if it cannot be drawn again.
    pub(crate) fn set_last_constants(&mut self, constants: Option<FrameConstants>) {
        if let Some(redraw) = &mut self.redraw {
            redraw.constants = constants;
        }
    }
}
