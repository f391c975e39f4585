//! Tables, values and pass times of a [`Post`] that are read back after every frame.

use afterimage_gpu::GpuError;

use super::Post;
use super::buffer_copies::Reading;
use super::pass_times::PassTimes;
use super::readings::Watch;
use crate::error::PostError;

impl Post {
    /// Reads a table or value of a node, `node.port`, back after every frame from now on, without a wait. A node that
    /// the plan does not run has none.
    pub fn watch(&mut self, label: &str) -> Watch {
        self.names.queue();
        self.readings.watch(label)
    }

    /// The newest reading that has arrived: a few frames old, because nothing waits for it. Readings arrive while
    /// frames are recorded and submitted, and the device is polled.
    ///
    /// # Errors
    /// The watch is of another pipeline.
    pub fn reading(&self, watch: Watch) -> Result<Option<&Reading>, PostError> {
        self.readings.latest(watch)
    }

    /// Measures the GPU time of each pass of every frame from now on, without a wait. `false` where the device has no
    /// timestamps inside passes, and before a plan is loaded. A measured frame is a little slower, because the passes
    /// of a batch do not overlap.
    ///
    /// # Errors
    /// The device is lost or has no memory for the timestamps.
    pub fn time_passes(&mut self) -> Result<bool, GpuError> {
        self.executor.enable_timing()
    }

    /// The newest times of passes that have arrived, if they are [measured](Self::time_passes): a few frames old, like
    /// a [`reading`](Self::reading).
    pub fn pass_times(&self) -> Option<&PassTimes> {
        self.readings.pass_times.latest.as_ref()
    }
}
