//! The per-frame constants of shaders: time and number. They change in every frame, so where the device has immediates
//! they are part of the commands; a buffer needs a copy of its own.

use afterimage_plan::codegen::CodeOptions;
use wgpu::{Device, DeviceType, Features};

/// Bytes of the struct `Frame` of shaders.
pub(crate) const BYTES: u32 = 20;

/// The struct `Frame` of one frame, for most passes and for those whose memory begins in it.
#[derive(Clone, Copy, Default)]
pub(crate) struct FrameConstants([[u8; BYTES as usize]; 2]);

impl FrameConstants {
    /// Of the frame with this index. `time` and `dt` are in seconds; `reset` is whether histories begin in it.
    pub(crate) fn new(time: f64, dt: f32, index: u32, reset: bool) -> Self {
        let time = if time.is_finite() { time } else { 0.0 };
        // They wrap after 136 years, also before 0.
        let seconds = time.floor().rem_euclid(4_294_967_296.0) as u32;
        let part = (time - time.floor()) as f32;
        Self([reset, true].map(|reset| {
            let words = [seconds, part.to_bits(), dt.to_bits(), index, u32::from(reset)];
            bytemuck::cast(words.map(u32::to_le))
        }))
    }

    /// True if histories begin in the frame: then it is as for passes whose memory does.
    pub(crate) fn reset(&self) -> bool {
        self.0[0] == self.0[1]
    }

    pub(crate) fn bytes(&self, is_uninitialized: bool) -> &[u8] {
        &self.0[usize::from(is_uninitialized)]
    }
}

/// The way in which passes of a device read their numbers.
pub(crate) fn code_options(device: &Device) -> CodeOptions {
    CodeOptions {
        immediates: has_immediates(device),
        on_processor: device.adapter_info().device_type == DeviceType::Cpu,
        ..CodeOptions::default()
    }
}

/// True if passes can take the constants from immediates.
fn has_immediates(device: &Device) -> bool {
    device.features().contains(Features::IMMEDIATES) && device.limits().max_immediate_size >= BYTES
}
