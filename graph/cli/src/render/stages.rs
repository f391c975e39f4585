//! The stages of `render`: reading, rendering and writing overlap.

use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use afterimage_graph::check::{Facts, Graph};
use afterimage_plan::Options;

use super::frames::render_all;
use super::read::{Inputs, read_all};
use super::readings::{Report, meters};
use super::request::Request;
use super::times::Times;
use super::watch_cache::{Repetition, WatchCache};
use super::write::{Queue, Written, write_all};
use crate::device;
use crate::failure::Failure;
use crate::process::{pool, spawn};
use crate::progress::Bar;

/// Frames between two stages: one in work and one that is ready.
pub(super) const AHEAD: usize = 2;
/// PNG compression keeps a core busy, so images are written on a quarter of the cores, but on at most this many
/// threads: each has a frame in memory.
const MAX_WRITERS: usize = 4;

/// Reads, renders and writes all images. The reader and the writers end with the stage between them. What is known of
/// the frames is in `report`, also after an error. `cache` has the state of the run before, and takes that of this run,
/// unless it fails.
pub(super) fn run(
    request: &Request<'_>,
    (graph, facts, options): (Graph, Facts, Options),
    mut cache: Option<&mut Option<WatchCache>>,
    report: &mut Report,
) -> Result<Times, Failure> {
    let start = Instant::now();
    let bar = Bar::of_frames(request.jobs.iter().filter(|job| job.is_written).count() as u64);
    let bar = &bar.for_farm(request.args.openjd);
    let (read_to, read_from) = sync_channel(AHEAD);
    let (write_to, write_from) = sync_channel(AHEAD);
    let writers = std::thread::available_parallelism().map_or(1, |cores| cores.get() / 4).clamp(1, MAX_WRITERS);
    // The frames of a film are written in order.
    let writers = if request.targets.iter().any(|target| target.film.is_some()) { 1 } else { writers };
    let meters = meters(&graph);
    let written = &Written::default();
    let before = cache.as_deref_mut().and_then(Option::take);
    let (session, pictures) = before.map_or((None, None), |before| (Some(before.session), before.pictures));
    let cached = pictures.filter(|pictures| pictures.suit(request));
    let (pictures, uploaded) = cached.map(|cached| (cached.pictures, cached.images)).unzip();
    let is_repeated = uploaded.is_some();
    let mut repetition = Repetition { uploaded, keeps: cache.is_some(), pictures: None };
    let times = std::thread::scope(|scope| {
        // Others than those that encode, behind whose work they would wait.
        let decoders = if pictures.is_none() { Some(pool("decode")?) } else { None };
        let read = move || match decoders {
            Some(decoders) => decoders.install(|| read_all(request, &read_to)),
            None => {
                let pictures = pictures.unwrap_or_default();
                // A receiver that is gone reports the error.
                let _ = read_to.send(Ok(Inputs { pictures, blocks: Vec::new() }));
                Duration::ZERO
            }
        };
        let reader = spawn(scope, "read", read)?;
        let queue = Arc::new(Queue::new(write_from));
        let mut writing = Vec::new();
        for _ in 0..writers {
            let queue = queue.clone();
            writing.push(spawn(scope, "write", move || write_all(request, &queue, written, bar))?);
        }
        // The last writer that ends closes the queue.
        drop(queue);
        let gpu = match &session {
            Some(session) => Ok(session.gpu().clone()),
            None => device::open_for(&request.args.device, &request.args.plan),
        };
        let session = gpu.map(|gpu| {
            let options = if repetition.keeps { gpu.options_to_repeat(options) } else { options };
            let Some(mut session) = session else { return device::session(&gpu, graph, facts, options) };
            if is_repeated {
                session.change(graph, options);
                session.post().set_facts(facts);
            } else {
                session.reset(graph, facts, options);
            }
            session
        });
        let start = start.elapsed();
        let rendered = session.and_then(|mut session| {
            let times = render_all(request, &mut session, meters, &mut repetition, read_from, write_to, report)?;
            // Otherwise the device is freed while the last image is written.
            if let Some(cache) = cache {
                *cache = Some(WatchCache { session, pictures: repetition.pictures });
            }
            Ok(times)
        });
        let read = reader.join().expect("the reader returns its errors");
        let busy = writing.into_iter().map(|writer| writer.join().expect("a writer returns its errors"));
        let busy = busy.collect::<Result<Vec<Duration>, _>>();
        let times = rendered?;
        let read = times.read + read;
        let write = times.write + busy?.iter().sum::<Duration>() / writers as u32;
        Ok::<_, Failure>(Times { start, read, write, writers, ..times })
    });
    let written = std::mem::take(&mut *written.lock().expect("no writer panics with the lock"));
    report.note_written(written, request.targets.len());
    Ok(Times { all: start.elapsed(), frames: request.jobs.len(), ..times? })
}
