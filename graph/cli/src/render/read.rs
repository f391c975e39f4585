//! The first stage of `render`: images are read.

use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use afterimage_graph::image::Signedness;
use afterimage_media::{Picture, Source, read_within};

use super::repairs::{Repairs, is_opaque};
use super::request::{Job, Request};
use crate::failure::Failure;

/// The image of an input, and what its file is worth.
pub(super) struct InputPicture {
    pub(super) name: String,
    pub(super) picture: Picture,
    /// The pixels that the graph repairs.
    pub(super) repairs: Repairs,
    /// Whether the input needs an alpha that the image does not have.
    pub(super) lacks_alpha: bool,
}

/// The images of a job.
pub(super) type Read = Result<Vec<InputPicture>, Failure>;

/// Reads the images of all jobs; returns the time that it takes.
pub(super) fn read_all(request: &Request<'_>, to: &SyncSender<Read>) -> Duration {
    let mut busy = Duration::ZERO;
    for job in &request.jobs {
        let start = Instant::now();
        let pictures = read_job(request, job);
        busy += start.elapsed();
        let failed = pictures.is_err();
        // A receiver that is gone has failed and reports the error.
        if to.send(pictures).is_err() || failed {
            break;
        }
    }
    busy
}

fn read_job(request: &Request<'_>, job: &Job) -> Read {
    job.sources.iter().map(|(name, source)| read_input(request, name, source)).collect()
}

fn read_input(request: &Request<'_>, name: &str, source: &Source) -> Result<InputPicture, Failure> {
    let picture = read_within(source, request.args.images.budget())?;
    let input = request.inputs.iter().find(|input| input.name == name);
    let signedness = input.map_or(Signedness::Unsigned, |input| input.state.signedness());
    let lacks_alpha = input.is_some_and(|input| input.needs_alpha) && is_opaque(&picture);
    let repairs = Repairs::of(&picture, signedness);
    Ok(InputPicture { name: name.to_owned(), picture, repairs, lacks_alpha })
}
