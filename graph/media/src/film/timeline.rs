//! The times of frames.

/// Times of frames in ticks of a time base, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// A tick is this share of a second.
    pub(super) tick: (u64, u64),
    pub(super) ticks: Vec<i64>,
    /// The tick at which the film begins, of which its sound counts.
    pub(super) start: i64,
    /// Ticks from one frame to the next where there is one frame alone.
    pub(super) usual: i64,
}

/// A number of frames in a number of seconds.
pub(super) type Rate = (u64, u64);

impl Timeline {
    /// The times of `count` frames at a rate, from 0 on. 23.976 and the like are thousandths of 1001.
    pub fn of_rate(fps: f64, count: usize) -> Self {
        let whole = (fps * 1.001).round();
        let is_ntsc = (fps - whole / 1.001).abs() < 5e-4 * whole && (fps - fps.round()).abs() > 1e-3;
        let (step, second) = if is_ntsc { (1001, whole * 1000.0) } else { (1000, (fps * 1000.0).round()) };
        let ticks = (0..count as i64).map(|frame| frame * step).collect();
        Self { tick: (1, second as u64), ticks, start: 0, usual: step }
    }

    /// The times of a film that begins after some seconds. A container may round them: where they lie at a rate that it
    /// states, they are those of the rate.
    pub(super) fn of_film(tick: (u64, u64), ticks: Vec<i64>, start: f64, rates: &[Rate]) -> Self {
        let exact = rates.iter().find_map(|rate| at_rate(tick, &ticks, *rate));
        let (tick, ticks, usual) = exact.unwrap_or_else(|| {
            let (frames, seconds) = rates.first().copied().unwrap_or((24, 1));
            let usual = (seconds as f64 / frames as f64 * tick.1 as f64 / tick.0 as f64).round() as i64;
            (tick, ticks, usual)
        });
        let start = (start * tick.1 as f64 / tick.0 as f64).round() as i64;
        let start = start.min(ticks[0]);
        Self { tick, ticks, start, usual }
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
        self.to_seconds(steps.get(steps.len() / 2).copied().unwrap_or(self.usual))
    }

    fn to_seconds(&self, ticks: i64) -> f64 {
        ticks as f64 * self.tick.0 as f64 / self.tick.1 as f64
    }
}

/// The times in ticks that the rate has, too, and its distance of two frames. `None` if some time is no multiple of it,
/// or if ticks are too long to tell.
fn at_rate(tick: (u64, u64), ticks: &[i64], (frames, seconds): Rate) -> Option<((u64, u64), Vec<i64>, i64)> {
    let second = tick.1.checked_mul(frames / common_divisor(tick.1, frames))?;
    // Time bases of `ffmpeg` are of 32 bits.
    let second_is_short = i32::try_from(second).is_ok();
    let old = i64::try_from(tick.0.checked_mul(second / tick.1)?).ok()?;
    let step = i64::try_from(seconds.checked_mul(second / frames)?).ok()?;
    if !second_is_short || step < old.checked_mul(4)? {
        return None;
    }
    let first = *ticks.first()?;
    let numbers = ticks.iter().map(|tick| {
        let since = tick.checked_sub(first)?.checked_mul(old)?;
        let number = (since + step / 2) / step;
        ((number * step - since).abs() <= old).then_some(number)
    });
    let numbers: Vec<i64> = numbers.collect::<Option<_>>()?;
    let first = first.checked_mul(old)?;
    let are_apart = numbers.windows(2).all(|pair| pair[0] < pair[1]);
    are_apart.then(|| ((1, second), numbers.iter().map(|number| first + number * step).collect(), step))
}

fn common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
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
        let film = Timeline { tick: (1, 24000), ticks: vec![2002, 3003, 5005], start: 1001, usual: 1001 };
        assert_eq!((film.nanoseconds(2, 0), film.seconds(0)), (125_125_000, 1001.0 / 24000.0));
        assert_eq!(film.of_frames([1, 2].into_iter()).ticks, [3003, 5005]);
        assert_eq!(Timeline::of_rate(29.97, 1).frame_seconds(), 1001.0 / 30000.0);
    }

    /// Matroska has whole milliseconds.
    #[test]
    fn times_that_were_rounded_are_those_of_the_rate() {
        for (frames, seconds) in [(24, 1), (24000, 1001), (25, 1), (30000, 1001), (60000, 1001), (120, 1)] {
            let rounded = |number: i64| (number as f64 * 1000.0 * seconds as f64 / frames as f64).round() as i64;
            // Some frames are left out.
            for numbers in [vec![0], vec![0, 1], (0..480).collect(), (0..480).filter(|n| n % 7 != 3).collect()] {
                let ticks = numbers.iter().map(|number| rounded(*number) + 7).collect();
                let film = Timeline::of_film((1, 1000), ticks, 0.004, &[(frames, seconds)]);
                let time = |number: i64| 0.003 + number as f64 * seconds as f64 / frames as f64;
                let error = |(index, number): (usize, &i64)| (film.seconds(index) - time(*number)).abs();
                assert!(numbers.iter().enumerate().map(error).all(|error| error < 1e-9), "{frames}/{seconds}");
                assert!((film.frame_seconds() - seconds as f64 / frames as f64).abs() < 1e-12, "{frames}/{seconds}");
            }
        }
        // Frames at times of their own stay there.
        for (ticks, rate) in [(vec![0, 41, 90, 125], (24, 1)), (vec![0, 3, 8], (1000, 1))] {
            let film = Timeline::of_film((1, 1000), ticks.clone(), 0.0, &[rate]);
            assert_eq!((film.tick, film.ticks), ((1, 1000), ticks));
        }
    }
}
