//! The first stage of `render`: images are read.

use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use afterimage_media::{Budget, Picture, read_within};

use super::request::Job;
use crate::failure::Failure;

/// The images of a job.
pub(super) type Read = Result<Vec<(String, Picture)>, Failure>;

/// Reads the images of all jobs; returns the time that it takes.
pub(super) fn read_all(jobs: &[Job], budget: Budget, to: &SyncSender<Read>) -> Duration {
    let mut busy = Duration::ZERO;
    for job in jobs {
        let start = Instant::now();
        let pictures = read_job(job, budget);
        busy += start.elapsed();
        let failed = pictures.is_err();
        // A receiver that is gone has failed and reports the error.
        if to.send(pictures).is_err() || failed {
            break;
        }
    }
    busy
}

fn read_job(job: &Job, budget: Budget) -> Read {
    job.sources.iter().map(|(name, source)| Ok((name.clone(), read_within(source, budget)?))).collect()
}
