//! The per-frame constants of shaders: time and number. They change in every frame, so where the device has immediates
//! they are part of the commands; a buffer needs a copy of its own.

use wgpu::{Device, Features};

use crate::executor::frame::Frame;

/// Bytes of the struct `Frame` of shaders.
pub(crate) const BYTES: u32 = 16;

/// The struct `Frame` of one frame, for most passes and for those whose memory begins in it.
#[derive(Clone, Copy, Default)]
pub(crate) struct FrameConstants([[u8; BYTES as usize]; 2]);

impl FrameConstants {
    pub(crate) fn new(frame: &Frame<'_>, index: u32, reset: bool) -> Self {
        let words = |reset: bool| [frame.time.to_bits(), frame.dt.to_bits(), index, u32::from(reset)];
        Self([reset, true].map(|reset| bytemuck::cast(words(reset).map(u32::to_le))))
    }

    pub(crate) fn bytes(&self, is_uninitialized: bool) -> &[u8] {
        &self.0[usize::from(is_uninitialized)]
    }
}

/// Whether passes can take the constants from immediates.
pub(crate) fn has_immediates(device: &Device) -> bool {
    device.features().contains(Features::IMMEDIATES) && device.limits().max_immediate_size >= BYTES
}
