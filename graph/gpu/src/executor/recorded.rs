//! Frames that are recorded and never submitted.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use wgpu::CommandEncoder;

/// The work that is lost with dropped commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Lost {
    Nothing,
    /// Uniforms, and results that outlive the frame.
    Commands,
    /// Also the beginning of histories and state.
    State,
}

/// The recorded frames that later ones rely on. Most frames are none: they read no more than others have left.
#[derive(Default)]
pub(crate) struct RecordedFrames(Arc<AtomicU8>);

/// Dropped with the commands of a frame, or called when they have run.
struct Watched {
    lost: Arc<AtomicU8>,
    what: Lost,
}

impl RecordedFrames {
    /// Notices if the commands of this encoder are dropped.
    pub(crate) fn watch(&self, encoder: &CommandEncoder, what: Lost) {
        let watched = Watched { lost: self.0.clone(), what };
        encoder.on_submitted_work_done(move || watched.have_run());
    }

    /// The work that was lost with frames dropped since the last call.
    pub(crate) fn take_lost(&self) -> Lost {
        match self.0.swap(Lost::Nothing as u8, Ordering::AcqRel) {
            0 => Lost::Nothing,
            1 => Lost::Commands,
            _ => Lost::State,
        }
    }
}

impl Watched {
    fn have_run(mut self) {
        self.what = Lost::Nothing;
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.lost.fetch_max(self.what as u8, Ordering::AcqRel);
    }
}
