//! Playback clock: play, pause, step.

use afterimage_gpu::FrameKind;

use super::Moment;

/// Seconds of a frame without a sequence of images.
const STEP: f64 = 1.0 / 60.0;
/// A longer pause between two frames is not played back.
const MAX_LENGTH: f64 = 0.1;

/// The time that frames are rendered at.
#[derive(Debug)]
pub struct PlayClock {
    /// Seconds since the start.
    pub time: f64,
    pub is_playing: bool,
    /// At the end, playback continues at the beginning.
    pub is_looping: bool,
    /// The part that is played, in seconds; an end without a point is that of the sequence.
    points: [Option<f64>; 2],
    /// Seconds of a frame, which is stepped by.
    frame_seconds: f64,
    /// The time of the last frame of a sequence.
    last_frame: Option<f64>,
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
        Self {
            time: 0.0,
            is_playing: true,
            is_looping: true,
            points: [None; 2],
            frame_seconds: STEP,
            last_frame: None,
            step: false,
            cut: true,
            was_sought: false,
            last: Moment::default(),
        }
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

    /// Takes the length of a sequence of images: its number of frames and how many there are in a second.
    pub(super) fn set_length(&mut self, length: Option<(usize, f64)>) {
        self.frame_seconds = length.map_or(STEP, |(_, fps)| 1.0 / fps);
        self.last_frame = length.map(|(count, fps)| (count as f64 - 1.0) / fps);
    }

    /// The first and the last time of the part that is played, as far as the user has set them.
    pub fn points(&self) -> [Option<f64>; 2] {
        self.points
    }

    /// Sets the beginning or, as `index` 1, the end of the part that is played to the present time, or takes it back
    /// if it is there. A point on the wrong side of the other one replaces both.
    pub fn mark(&mut self, index: usize) {
        let is_here = self.points[index].is_some_and(|point| (point - self.time).abs() < 0.5 * self.frame_seconds);
        self.points[index] = (!is_here).then_some(self.time);
        if let [Some(first), Some(last)] = self.points
            && first > last
        {
            self.points[1 - index] = None;
        }
    }

    /// At the end of the part that is played, goes to its beginning, which has no history, or stops.
    fn turn_at_end(&mut self) {
        let [first, last] = [self.points[0].unwrap_or(0.0), self.points[1].or(self.last_frame).unwrap_or(f64::MAX)];
        if self.time <= last + 0.5 * self.frame_seconds {
            return;
        }
        match self.is_looping {
            true => (self.time, self.cut) = (first, true),
            false => (self.time, self.is_playing) = (last, false),
        }
    }

    /// The number of the shown frame, from 0.
    pub fn frame(&self) -> u32 {
        (self.time / self.frame_seconds).round() as u32
    }

    /// True if the shown frame was sought: it has no history.
    pub fn is_cut_shown(&self) -> bool {
        self.was_sought
    }

    /// The moment of the next frame, `elapsed` seconds after the last one; `None` if it is the same as before.
    pub fn advance(&mut self, elapsed: f64) -> Option<Moment> {
        let dt = match (self.is_playing, std::mem::take(&mut self.step)) {
            (true, _) => elapsed.clamp(0.0, MAX_LENGTH),
            (false, true) => self.frame_seconds,
            (false, false) if self.cut => 0.0,
            (false, false) => return None,
        };
        // A cut is a first frame: nothing has passed since the one before.
        self.time += if self.cut { 0.0 } else { dt };
        if self.is_playing {
            self.turn_at_end();
        }
        let is_cut = std::mem::take(&mut self.cut);
        let dt = if is_cut { 0.0 } else { dt };
        self.was_sought &= is_cut;
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
    fn a_sequence_is_stepped_by_frames_and_played_between_its_points() {
        let mut clock = PlayClock::default();
        clock.set_length(Some((10, 25.0)));
        clock.advance(0.0);
        clock.step();
        assert_eq!(clock.advance(0.0).map(|moment| moment.dt), Some(0.04));
        clock.seek(0.2);
        clock.mark(1);
        clock.seek(0.12);
        clock.mark(0);
        assert_eq!(clock.points(), [Some(0.12), Some(0.2)]);
        clock.is_playing = true;
        clock.advance(0.0);
        let frames: Vec<(u32, FrameKind)> =
            (0..5).filter_map(|_| clock.advance(0.04).map(|moment| (clock.frame(), moment.kind))).collect();
        let [next, cut] = [false, true].map(FrameKind::cut_if);
        assert_eq!(frames, [(4, next), (5, next), (3, cut), (4, next), (5, next)]);
        clock.is_looping = false;
        clock.advance(0.04);
        assert_eq!((clock.frame(), clock.is_playing), (5, false));
        // The same point again takes it back; one beyond the other replaces it.
        clock.mark(1);
        assert_eq!(clock.points(), [Some(0.12), None]);
        clock.seek(0.0);
        clock.mark(1);
        assert_eq!(clock.points(), [None, Some(0.0)]);
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
