//! The state before the last frame, from which it is drawn again.

use afterimage_plan::Plan;
use wgpu::{Buffer, BufferUsages, CommandEncoder, Device};

use crate::buffer::buffer;
use crate::executor::host_draw::has_host_draws;
use crate::executor::loaded::due_passes::{DuePasses, WrittenBuffer};
use crate::frame_constants::FrameConstants;

/// The state before the last frame.
pub(crate) struct Redraw {
    /// Each persistent buffer, the passes that write it, and a copy.
    state: Vec<(Buffer, WrittenBuffer, Buffer)>,
    /// The constants of the last frame, if it can be drawn again.
    pub(crate) constants: Option<FrameConstants>,
}

impl Redraw {
    /// `None` for plans that need not be drawn again, that do not run all passes in each frame, or that the host draws
    /// into.
    pub(crate) fn new(device: &Device, plan: &Plan, buffers: &[Buffer], persistent: &[WrittenBuffer]) -> Option<Self> {
        if !plan.options.repeatable || !plan.runs_all_passes() || has_host_draws(plan) {
            return None;
        }
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let state = persistent.iter().map(|written| {
            let own = buffers[written.index].clone();
            let saved = buffer(device, "state before a frame", own.size(), usage);
            (own, written.clone(), saved)
        });
        Some(Self { state: state.collect(), constants: None })
    }

    /// Records, before a frame, a copy of the state to draw the frame again from.
    pub(crate) fn save(&self, encoder: &mut CommandEncoder) {
        for (own, _, saved) in &self.state {
            encoder.copy_buffer_to_buffer(own, 0, saved, 0, None);
        }
    }

    /// Restores, before the last frame is drawn again, the state that the passes write which run.
    pub(crate) fn restore(&self, due: &DuePasses, encoder: &mut CommandEncoder) {
        for (own, _, saved) in self.state.iter().filter(|(_, written, _)| due.writes(written)) {
            encoder.copy_buffer_to_buffer(saved, 0, own, 0, None);
        }
    }
}
