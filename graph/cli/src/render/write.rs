//! The last stage of `render`: images are written.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use afterimage_gpu::Texels;
use afterimage_media::Metadata;
use afterimage_plan::PlanOutput;
use indicatif::ProgressBar;

use super::request::Request;
use crate::failure::Failure;
use crate::save::{Stated, save};

/// A rendered image.
pub(super) struct Rendered {
    pub(super) texels: Texels,
    pub(super) output: PlanOutput,
    pub(super) meta: Option<Metadata>,
    /// Of its job.
    pub(super) index: usize,
    pub(super) target: usize,
}

/// Shared by the writers: the rendered images, and whether a writer has failed, so that the others stop.
pub(super) struct Queue {
    from: Mutex<Receiver<Rendered>>,
    failed: AtomicBool,
}

impl Queue {
    pub(super) fn new(from: Receiver<Rendered>) -> Self {
        Self { from: Mutex::new(from), failed: AtomicBool::new(false) }
    }

    /// The next image; `None` after the last one, or if another writer has failed.
    fn next(&self) -> Option<Rendered> {
        let next = self.from.lock().expect("no writer panics with the lock").recv().ok();
        next.filter(|_| !self.failed.load(Ordering::Relaxed))
    }
}

/// Writes what the queue holds; returns the time that it takes.
pub(super) fn write_all(request: &Request<'_>, queue: &Queue, bar: &ProgressBar) -> Result<Duration, Failure> {
    let mut busy = Duration::ZERO;
    while let Some(rendered) = queue.next() {
        let start = Instant::now();
        let path = &request.jobs[rendered.index].out[rendered.target];
        let stated = Stated { meta: rendered.meta, frame: rendered.index, ..Stated::of(&rendered.output) };
        let saved = save(path, &rendered.texels, stated, &request.targets[rendered.target].saving);
        queue.failed.fetch_or(saved.is_err(), Ordering::Relaxed);
        saved?;
        busy += start.elapsed();
        // The bar counts frames; the last target ends one.
        bar.inc(u64::from(rendered.target + 1 == request.targets.len()));
    }
    Ok(busy)
}
