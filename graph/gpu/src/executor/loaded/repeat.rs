//! What a plan keeps so that its last frame can be repeated in part.

use afterimage_plan::Plan;
use wgpu::{Buffer, BufferUsages, Device};

use crate::buffer::buffer;
use crate::executor::host_draw::host_node;
use crate::frame_constants::FrameConstants;

/// The last frame.
pub(crate) struct Repeat {
    /// What outlives frames, as it was before the last frame: a buffer for each persistent one.
    pub(crate) state: Vec<Buffer>,
    /// What the last frame has seen.
    pub(crate) uniforms: Vec<u8>,
    /// The constants of the last frame, if it can be repeated.
    pub(crate) constants: Option<FrameConstants>,
}

impl Repeat {
    /// `None` for plans that are not to be repeated, whose results are held in turns, or that the host draws into.
    pub(crate) fn new(device: &Device, plan: &Plan, buffers: &[Buffer], persistent: &[usize]) -> Option<Self> {
        let has_host_draws = plan.work().any(|pass| host_node(pass).is_some());
        if !plan.options.repeatable || !plan.held.is_empty() || has_host_draws {
            return None;
        }
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let copy_of = |index: &usize| buffer(device, "the state before a frame", buffers[*index].size(), usage);
        Some(Self { state: persistent.iter().map(copy_of).collect(), uniforms: Vec::new(), constants: None })
    }

    /// Whether this range of the uniforms has other bytes than in the last frame.
    pub(crate) fn differs(&self, uniforms: &[u8], offset: u64, length: usize) -> bool {
        let range = offset as usize..offset as usize + length;
        uniforms[range.clone()] != self.uniforms[range]
    }
}
