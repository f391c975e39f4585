//! Times of the stages of `render`.

use std::time::Duration;

/// The time of each stage.
#[derive(Default)]
pub(super) struct Times {
    /// Until the device is open; images are read at the same time.
    pub(super) start: Duration,
    pub(super) read: Duration,
    pub(super) render: Duration,
    /// Of each writer, on average.
    pub(super) write: Duration,
    pub(super) writers: usize,
    pub(super) all: Duration,
    pub(super) frames: usize,
    /// GPU milliseconds of each pass, where the adapter can time it.
    pub(super) passes: Vec<(String, Option<f64>)>,
}

/// The reason why passes have no times.
const UNTIMED: &str = "this adapter cannot time the passes of a frame; `afterimage bench` times each pass alone";

impl Times {
    /// The lines that `--timings` prints.
    pub(super) fn lines(&self) -> Vec<String> {
        let ms = |time: Duration| time.as_secs_f64() * 1e3 / self.frames.max(1) as f64;
        let frames = if self.frames == 1 { "1 frame".to_owned() } else { format!("{} frames", self.frames) };
        let writers = if self.writers > 1 { format!("; {} threads write", self.writers) } else { String::new() };
        let mut lines = vec![
            format!("{frames} in {:.3} s; milliseconds a frame:", self.all.as_secs_f64()),
            format!("  read {:.1}, render {:.1}, write {:.1}", ms(self.read), ms(self.render), ms(self.write)),
            format!("  the device opened in {:.1}{writers}", self.start.as_secs_f64() * 1e3),
        ];
        lines.extend(self.passes.iter().map(|(label, ms)| match ms {
            Some(ms) => format!("  {ms:8.4} ms on the GPU: {label}"),
            None => format!("  not timed: {label}"),
        }));
        if self.passes.iter().any(|(_, ms)| ms.is_none()) {
            lines.push(format!("  {UNTIMED}"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_stages_are_those_of_a_frame() {
        let ms = Duration::from_millis;
        let times =
            Times { start: ms(80), read: ms(30), render: ms(100), write: ms(7), all: ms(1250), ..Times::default() };
        let passes = vec![("timed".to_owned(), Some(0.5)), ("other".to_owned(), None)];
        let lines = Times { frames: 2, writers: 3, passes, ..times }.lines();
        let shown = [
            "2 frames in 1.250 s; milliseconds a frame:",
            "  read 15.0, render 50.0, write 3.5",
            "  the device opened in 80.0; 3 threads write",
            "    0.5000 ms on the GPU: timed",
            "  not timed: other",
        ];
        assert_eq!(lines[..5], shown);
        assert!(lines.len() == 6 && lines[5].contains(UNTIMED), "{lines:?}");
        let one = Times { frames: 1, writers: 1, ..Times::default() }.lines();
        assert!(one.len() == 3 && one[0].starts_with("1 frame in ") && one[2].ends_with("in 0.0"), "{one:?}");
    }
}
