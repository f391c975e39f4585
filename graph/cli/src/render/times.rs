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
const UNTIMED: &str = "this adapter has no timestamps that part passes; `afterimage bench` times each pass alone";

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |time: Duration| time.as_secs_f64() * 1e3 / self.frames.max(1) as f64;
        let frames = if self.frames == 1 { "1 frame".to_owned() } else { format!("{} frames", self.frames) };
        writeln!(f, "{frames} in {:.3} s; milliseconds a frame:", self.all.as_secs_f64())?;
        writeln!(f, "  read {:.1}, render {:.1}, write {:.1}", ms(self.read), ms(self.render), ms(self.write))?;
        let writers = if self.writers > 1 { format!("; {} threads write", self.writers) } else { String::new() };
        writeln!(f, "  the device opened in {:.1}{writers}", self.start.as_secs_f64() * 1e3)?;
        for (label, ms) in &self.passes {
            match ms {
                Some(ms) => writeln!(f, "  {ms:8.4} ms on the GPU: {label}")?,
                None => writeln!(f, "  not timed: {label}")?,
            }
        }
        if self.passes.iter().any(|(_, ms)| ms.is_none()) { writeln!(f, "  {UNTIMED}") } else { Ok(()) }
    }
}
