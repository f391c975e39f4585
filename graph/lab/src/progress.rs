//! Progress of a long measurement.

/// Receives the progress of a measurement. `()` ignores it.
pub trait Progress {
    /// The number of steps is now known to be `steps`.
    fn expect(&self, _steps: u64) {}

    fn begin(&self, _step: &str) {}

    /// Reports the position within the current step.
    fn reach(&self, _place: &str) {}

    fn end(&self) {}
}

impl Progress for () {}
