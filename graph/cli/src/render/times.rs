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
