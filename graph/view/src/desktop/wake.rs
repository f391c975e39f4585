//! Wakes the event loop from other threads.

use std::sync::{Arc, OnceLock};

/// Draws a frame of the window, from any thread. Before the window is there it does nothing.
#[derive(Clone, Default)]
pub struct Wake(Arc<OnceLock<Box<dyn Fn() + Send + Sync>>>);

impl Wake {
    pub fn call(&self) {
        if let Some(wake) = self.0.get() {
            wake();
        }
    }

    /// Sets the function that wakes it. Only the first call counts.
    pub(super) fn set(&self, wake: impl Fn() + Send + Sync + 'static) {
        let _ = self.0.set(Box::new(wake));
    }
}
