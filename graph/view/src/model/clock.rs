//! Playback clock: play, pause, step.

use afterimage_gpu::FrameKind;

use super::Moment;

/// Seconds of a frame that is stepped to.
const STEP: f64 = 1.0 / 60.0;
/// A longer pause between two frames is not played back.
const MAX_LENGTH: f64 = 0.1;

/// The time that frames are rendered at.
#[derive(Debug)]
pub struct PlayClock {
    /// Seconds since the start.
    pub time: f64,
    pub is_playing: bool,
    /// The next frame is rendered although playback is paused.
    step: bool,
    /// The next frame is a cut.
    cut: bool,
    /// The last frame was sought, and has no history.
    was_sought: bool,
    /// The moment of the last frame.
    last: Moment,
}

impl Default for PlayClock {
    fn default() -> Self {
        Self { time: 0.0, is_playing: true, step: false, cut: true, was_sought: false, last: Moment::default() }
    }
}

impl PlayClock {
    /// The next frame is rendered one step later.
    pub fn step(&mut self) {
        (self.is_playing, self.step) = (false, true);
    }

    /// The next frame begins without its history.
    pub fn cut(&mut self) {
        self.cut = true;
    }

    /// Goes to a time. What is shown there has no history.
    pub fn seek(&mut self, time: f64) {
        (self.time, self.cut, self.was_sought) = (time.max(0.0), true, true);
    }

    /// The number of the shown frame, of which each is a step long.
    pub fn frame(&self) -> u32 {
        (self.time / STEP).round() as u32
    }

    /// True if the shown frame was sought: it has no history.
    pub fn is_cut_shown(&self) -> bool {
        self.was_sought
    }

    /// The moment of the next frame, `elapsed` seconds after the last one; `None` if it is the same as before.
    pub fn advance(&mut self, elapsed: f64) -> Option<Moment> {
        let dt = match (self.is_playing, std::mem::take(&mut self.step)) {
            (true, _) => elapsed.clamp(0.0, MAX_LENGTH),
            (false, true) => STEP,
            (false, false) if self.cut => 0.0,
            (false, false) => return None,
        };
        let is_cut = std::mem::take(&mut self.cut);
        // A cut is a first frame: nothing has passed since the one before.
        let dt = if is_cut { 0.0 } else { dt };
        self.was_sought &= is_cut;
        self.time += dt;
        self.last = Moment { time: self.time, dt, kind: FrameKind::cut_if(is_cut) };
        Some(self.last)
    }

    /// The moment of the last frame again.
    pub fn again(&self) -> Moment {
        Moment { kind: FrameKind::Redraw, ..self.last }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_stands_in_a_pause_and_a_step_is_a_sixtieth() {
        let mut clock = PlayClock::default();
        assert_eq!(clock.advance(0.02), Some(Moment { kind: FrameKind::Cut, ..Moment::default() }));
        assert_eq!(clock.advance(0.02), Some(Moment { time: 0.02, dt: 0.02, ..Moment::default() }));
        clock.is_playing = false;
        assert_eq!(clock.advance(0.02), None);
        clock.step();
        let stepped = clock.advance(7.0).expect("a step is a frame");
        assert!((stepped.time - 0.02 - STEP).abs() < 1e-12 && stepped.dt == STEP, "{stepped:?}");
        assert_eq!(clock.advance(0.02), None);
    }

    #[test]
    fn a_window_that_was_away_does_not_jump_and_a_cut_has_no_history() {
        let mut clock = PlayClock::default();
        clock.advance(0.0);
        assert_eq!(clock.advance(60.0).map(|moment| moment.dt), Some(MAX_LENGTH));
        clock.is_playing = false;
        clock.seek(3.0);
        assert_eq!(clock.advance(0.02), Some(Moment { time: 3.0, kind: FrameKind::Cut, ..Moment::default() }));
    }
}
