//! The times of frames.

/// Times of frames in ticks of a time base, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// A tick is this share of a second.
    pub(super) tick: (u64, u64),
    pub(super) ticks: Vec<i64>,
    /// The tick at which the film begins, of which its sound counts.
    pub(super) start: i64,
}

impl Timeline {
    /// The times of `count` frames at a rate, from 0 on. 23.976 and the like are thousandths of 1001.
    pub fn of_rate(fps: f64, count: usize) -> Self {
        let whole = (fps * 1.001).round();
        let is_ntsc = (fps - whole / 1.001).abs() < 5e-4 * whole && (fps - fps.round()).abs() > 1e-3;
        let (step, second) = if is_ntsc { (1001, whole * 1000.0) } else { (1000, (fps * 1000.0).round()) };
        let ticks = (0..count as i64).map(|frame| frame * step).collect();
        Self { tick: (1, second as u64), ticks, start: 0 }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.ticks.len()
    }

    /// The time of a frame in seconds, by its index.
    pub fn seconds(&self, index: usize) -> f64 {
        self.to_seconds(self.ticks[index] - self.start)
    }

    /// The time of a frame after that of another one in nanoseconds.
    pub(super) fn nanoseconds(&self, index: usize, since: usize) -> u64 {
        let ticks = (self.ticks[index] - self.ticks[since]).max(0) as u128;
        let (share, second) = (u128::from(self.tick.0), u128::from(self.tick.1));
        ((ticks * share * 1_000_000_000 + second / 2) / second) as u64
    }

    /// The frames of these indices alone.
    pub fn of_frames(&self, indices: impl Iterator<Item = usize>) -> Self {
        Self { ticks: indices.map(|index| self.ticks[index]).collect(), ..*self }
    }

    /// The usual distance of two frames in seconds.
    pub fn frame_seconds(&self) -> f64 {
        let mut steps: Vec<i64> = self.ticks.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_unstable();
        steps.get(steps.len() / 2).map_or(1.0 / 24.0, |step| self.to_seconds(*step))
    }

    fn to_seconds(&self, ticks: i64) -> f64 {
        ticks as f64 * self.tick.0 as f64 / self.tick.1 as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_the_fractions_that_are_meant() {
        for (fps, step, second) in [
            (24.0, 1000, 24000),
            (23.976, 1001, 24000),
            (23.98, 1001, 24000),
            (29.97, 1001, 30000),
            (59.94, 1001, 60000),
            (25.0, 1000, 25000),
            (12.5, 1000, 12500),
        ] {
            let times = Timeline::of_rate(fps, 3);
            assert_eq!((times.ticks[1], times.tick), (step, (1, second)), "{fps}");
        }
        let film = Timeline { tick: (1, 24000), ticks: vec![2002, 3003, 5005], start: 1001 };
        assert_eq!((film.nanoseconds(2, 0), film.seconds(0)), (125_125_000, 1001.0 / 24000.0));
        assert_eq!(film.of_frames([1, 2].into_iter()).ticks, [3003, 5005]);
    }
}
