//! The numbers of frames, and the frames that reset histories and adaptation.

use super::frame::{Frame, FrameKind};
use crate::frame_constants::FrameConstants;

/// Counts the frames of an executor.
pub struct FrameCounter {
    /// The number of the next frame since the last reset of the count: it selects the textures of histories.
    pub(crate) index: u32,
    /// The difference between it and the number that shaders see.
    offset: u32,
    /// The number that shaders saw in the last frame; `None` if it is the one before that of the next frame.
    last: Option<u32>,
    /// The constants of the last frame.
    pub(crate) constants: FrameConstants,
    /// The next frame resets histories and adaptation.
    pub is_fresh: bool,
}

/// The numbers of one frame.
#[derive(Clone, Copy)]
pub(crate) struct FrameNumbers {
    /// The number that selects the textures of histories.
    pub(crate) index: u32,
    /// The number that shaders see.
    pub(crate) number: u32,
    /// The number that shaders saw in the frame before.
    pub(crate) before: u32,
    /// The frame resets histories and adaptation.
    pub(crate) resets: bool,
    /// The frame is the last one with other values of parameters.
    pub(crate) is_redraw: bool,
}

impl Default for FrameCounter {
    fn default() -> Self {
        Self { index: 0, offset: 0, last: None, constants: FrameConstants::default(), is_fresh: true }
    }
}

impl FrameCounter {
    pub(crate) fn count_from(&mut self, index: u32) {
        (self.index, self.offset, self.is_fresh) = (index, 0, true);
    }

    pub(crate) fn number_next(&mut self, number: u32) {
        self.offset = number.wrapping_sub(self.index);
    }

    /// Continues the frames of another executor.
    pub(crate) fn continue_from(&mut self, other: &Self) {
        (self.index, self.offset, self.last, self.is_fresh) = (other.index, other.offset, other.last, false);
    }

    /// The number that shaders saw in the last frame; that of the next one before any.
    pub fn last_number(&self) -> u32 {
        self.last.unwrap_or(self.next_number())
    }

    /// The numbers of the next frame.
    pub(crate) fn next(&self, kind: FrameKind) -> FrameNumbers {
        let is_redraw = kind == FrameKind::Redraw && !self.is_fresh;
        let resets = self.is_fresh || kind == FrameKind::Cut || is_redraw && self.constants.reset();
        let (index, number) = match self.last {
            Some(last) if is_redraw => (self.index.wrapping_sub(1), last),
            _ => (self.index, self.next_number()),
        };
        let before = self.last.unwrap_or(number.wrapping_sub(1));
        FrameNumbers { index, number, before, resets, is_redraw }
    }

    /// Notes that a frame is recorded.
    pub(crate) fn finish(&mut self, numbers: FrameNumbers, constants: FrameConstants) {
        self.last = Some(numbers.number);
        self.index = numbers.index.wrapping_add(1);
        self.constants = constants;
        self.is_fresh = false;
    }

    fn next_number(&self) -> u32 {
        self.index.wrapping_add(self.offset)
    }
}

impl FrameNumbers {
    /// The constants of a frame. No time passes in a redraw: the plan has the state after the last frame.
    pub(crate) fn constants(&self, frame: &Frame<'_>) -> FrameConstants {
        let dt = if self.is_redraw { 0.0 } else { frame.dt };
        FrameConstants::new(frame.time, dt, self.number, self.resets)
    }
}
