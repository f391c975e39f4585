//! The per-frame constants of shaders: time and number. They change in every frame, so where the device has immediates
//! they are part of the commands; a buffer needs a copy of its own.

use wgpu::{Device, Features};

use super::frame::Frame;

/// Bytes of the struct `Frame` of shaders.
pub(super) const BYTES: u32 = 16;

/// The struct `Frame` of one frame, for most passes and for those whose memory begins in it.
#[derive(Clone, Copy, Default)]
pub(super) struct FrameConstants([[u8; BYTES as usize]; 2]);

impl FrameConstants {
    pub(super) fn new(frame: &Frame<'_>, index: u32, reset: bool) -> Self {
        let words = |reset: bool| [frame.time.to_bits(), frame.dt.to_bits(), index, u32::from(reset)];
        Self([reset, true].map(|reset| bytemuck::cast(words(reset).map(u32::to_le))))
    }

    pub(super) fn bytes(&self, is_uninitialized: bool) -> &[u8] {
        &self.0[usize::from(is_uninitialized)]
    }
}

/// Where in the rings and when a frame is.
pub(super) type FrameConstantsAt<'m> = (usize, &'m FrameConstants);

/// Whether passes can take the constants from immediates.
pub(super) fn has_immediates(device: &Device) -> bool {
    device.features().contains(Features::IMMEDIATES) && device.limits().max_immediate_size >= BYTES
}
