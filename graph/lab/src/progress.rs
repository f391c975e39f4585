//! What a long measurement reports while it runs.

/// Receives the progress of a measurement. `()` ignores it.
pub trait Progress {
    /// The number of steps is now known to be `steps`.
    fn expect(&self, _steps: u64) {}

    fn begin(&self, _step: &str) {}

    fn end(&self) {}
}

impl Progress for () {}
