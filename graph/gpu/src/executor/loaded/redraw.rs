//! The state before the last frame, from which it is drawn again.

use afterimage_plan::Plan;
use wgpu::{Buffer, BufferUsages, Device};

use crate::buffer::buffer;
use crate::executor::host_draw::host_node;
use crate::executor::loaded::due_passes::WrittenBuffer;
use crate::frame_constants::FrameConstants;

/// The state before the last frame.
pub(crate) struct Redraw {
    /// A copy of each persistent buffer.
    pub(crate) state: Vec<Buffer>,
    /// The constants of the last frame, if it can be drawn again.
    pub(crate) constants: Option<FrameConstants>,
}

impl Redraw {
    /// `None` for plans that need not be drawn again, that do not run all passes in each frame, or that the host draws
    /// into.
    pub(crate) fn new(device: &Device, plan: &Plan, buffers: &[Buffer], persistent: &[WrittenBuffer]) -> Option<Self> {
        let has_host_draws = plan.work().any(|pass| host_node(pass).is_some());
        if !plan.options.repeatable || !plan.runs_all_passes() || has_host_draws {
            return None;
        }
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let size = |persistent: &WrittenBuffer| buffers[persistent.index].size();
        let copies =
            persistent.iter().map(|persistent| buffer(device, "state before a frame", size(persistent), usage));
        Some(Self { state: copies.collect(), constants: None })
    }
}
