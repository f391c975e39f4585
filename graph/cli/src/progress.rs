//! The progress of long commands: a bar on a terminal, and a line every few seconds elsewhere.

use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use afterimage_graph::diagnostic::shown;
use afterimage_lab::Progress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::terminal::{note, report_to_farm};

/// The time between two lines where standard error is no terminal.
const PAUSE: Duration = Duration::from_secs(5);

/// A bar on standard error; it disappears when it is dropped.
pub(crate) struct Bar {
    bar: ProgressBar,
    /// The name of the steps.
    what: &'static str,
    /// Prefix of the number of all steps and of the time left, if both are upper limits.
    most: &'static str,
    start: Instant,
    /// The time of the last line; `None` on a terminal.
    written: Option<Mutex<Instant>>,
    /// True if each step is a line of Open Job Description on standard output.
    openjd: bool,
}

impl Bar {
    /// A bar of `count` steps, with the step's name.
    pub(crate) fn new(count: u64) -> Self {
        Self::with(ProgressBar::new(count), "{bar:24} {pos}/{len}, {eta} left; {wide_msg}", "steps", "")
    }

    /// A bar of steps that a search makes, of which only the largest number is known.
    pub(crate) fn at_most() -> Self {
        let template = "{bar:24} {pos} of at most {len}, at most {eta} left; {wide_msg}";
        Self::with(ProgressBar::new(0), template, "steps", "at most ")
    }

    /// A bar of `count` frames; none for a single one.
    pub(crate) fn of_frames(count: u64) -> Self {
        let bar = if count < 2 { ProgressBar::hidden() } else { ProgressBar::new(count) };
        bar.set_length(count);
        Self::with(bar, "{wide_bar} {pos}/{len} frames, {eta} left", "frames", "")
    }

    fn with(bar: ProgressBar, template: &str, what: &'static str, most: &'static str) -> Self {
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let start = Instant::now();
        let written = (!std::io::stderr().is_terminal()).then(|| Mutex::new(start));
        Self { bar: bar.with_style(style), what, most, start, written, openjd: false }
    }

    /// The same, and each step prints what the session of a farm reads (Open Job Description, "How Jobs Are Run").
    pub(crate) fn for_farm(mut self, openjd: bool) -> Self {
        self.openjd = openjd;
        self
    }

    /// One step more is done. `name` begins the line, if one is written.
    pub(crate) fn advance(&self, name: &str) {
        self.bar.inc(1);
        let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
        if self.openjd {
            let share = 100.0 * done as f64 / all.max(1) as f64;
            report_to_farm("progress", &format!("{share:.1}"));
            report_to_farm("status", &format!("{name}, {done} of {all} {}", self.what));
        }
        if done < all {
            self.note(name);
        }
    }

    /// Writes a line where standard error is no terminal, if the last one is some time ago.
    fn note(&self, name: &str) {
        let Some(written) = &self.written else { return };
        let mut written = written.lock().expect("no thread panics with the lock");
        if written.elapsed() >= PAUSE {
            *written = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
            note(&format!("{name}: {}", line(done, all, self.what, self.most, self.start.elapsed())));
        }
    }
}

/// `12 of 96 frames, 3.1 a second, 0:27 left`; before the first one there is no rate.
fn line(done: u64, all: u64, what: &str, most: &str, elapsed: Duration) -> String {
    if done == 0 {
        return format!("{done} of {most}{all} {what}");
    }
    let rate = done as f64 / elapsed.as_secs_f64().max(1e-3);
    let left = ((all - done) as f64 / rate).round() as u64;
    let (hours, minutes, seconds) = (left / 3600, left / 60 % 60, left % 60);
    let left = if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") };
    let speed = if rate < 1.0 { format!("{:.1} s each", 1.0 / rate) } else { format!("{rate:.1} a second") };
    format!("{done} of {most}{all} {what}, {speed}, {most}{left} left")
}

impl Progress for Bar {
    fn expect(&self, steps: u64) {
        self.bar.set_length(steps);
    }

    fn begin(&self, step: &str) {
        self.bar.set_message(shown(step).into_owned());
    }

    fn reach(&self, place: &str) {
        self.bar.set_message(shown(place).into_owned());
        self.note(place);
    }

    fn end(&self) {
        self.advance(&self.bar.message());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_rate_and_the_time_left() {
        let of_frames = |done, seconds| line(done, 96, "frames", "", Duration::from_secs(seconds));
        assert_eq!(of_frames(12, 4), "12 of 96 frames, 3.0 a second, 0:28 left");
        assert_eq!(of_frames(1, 90), "1 of 96 frames, 90.0 s each, 2:22:30 left");
        assert_eq!(of_frames(0, 7), "0 of 96 frames");
        assert_eq!(of_frames(95, 95), "95 of 96 frames, 1.0 a second, 0:01 left");
        let search = line(12, 96, "steps", "at most ", Duration::from_secs(4));
        assert_eq!(search, "12 of at most 96 steps, 3.0 a second, at most 0:28 left");
    }
}
