//! The progress bar of long commands.

use afterimage_lab::Progress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::terminal::visible;

/// A bar on standard error; it disappears when it is dropped.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    /// A bar of `steps` steps, with the step's name.
    pub(crate) fn new(steps: u64) -> Self {
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len}, {eta} left; {msg}");
        Self(ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
    }
}

impl Progress for Bar {
    fn expect(&self, steps: u64) {
        self.0.set_length(steps);
    }

    fn begin(&self, step: &str) {
        self.0.set_message(visible(step));
    }

    fn end(&self) {
        self.0.inc(1);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
