//! The stages of `render`: reading, rendering and writing overlap.

use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use afterimage_graph::check::{Facts, Graph};
use afterimage_plan::Options;
use indicatif::{ProgressBar, ProgressStyle};

use super::frames::render_all;
use super::read::read_all;
use super::readings::{FrameReport, meters};
use super::request::Request;
use super::times::Times;
use super::write::{Queue, write_all};
use crate::device::CachedSession;
use crate::failure::Failure;

/// Frames between two stages: one in work and one that is ready.
const AHEAD: usize = 2;
/// PNG compression keeps a core busy, so images are written on a quarter of the cores, but on at most this many
/// threads: each has a frame in memory.
const MAX_WRITERS: usize = 4;

/// Reads, renders and writes all images. The reader and the writers end with the stage between them.
pub(super) fn run(
    request: &Request<'_>,
    graph: Graph,
    facts: Facts,
    options: Options,
) -> Result<(Times, Vec<FrameReport>), Failure> {
    let start = Instant::now();
    let bar = &progress(request.jobs.len());
    let (read_to, read_from) = sync_channel(AHEAD);
    let (write_to, write_from) = sync_channel(AHEAD);
    let writers = std::thread::available_parallelism().map_or(1, |cores| cores.get() / 4).clamp(1, MAX_WRITERS);
    let meters = meters(&graph);
    let (times, reports) = std::thread::scope(|scope| {
        let reader = scope.spawn(move || read_all(request, &read_to));
        let queue = Arc::new(Queue::new(write_from));
        let spawn = |_| {
            let queue = queue.clone();
            scope.spawn(move || write_all(request, &queue, bar))
        };
        let writing: Vec<_> = (0..writers).map(spawn).collect();
        drop(queue);
        let session = CachedSession::open(&request.args.device, &request.args.plan, graph, facts, options);
        let start = start.elapsed();
        let rendered = session.and_then(|session| render_all(request, session, meters, read_from, write_to));
        let read = reader.join().expect("the reader returns its errors");
        let written = writing.into_iter().map(|writer| writer.join().expect("a writer returns its errors"));
        let written = written.collect::<Result<Vec<Duration>, _>>();
        let (times, reports) = rendered?;
        Ok::<_, Failure>((Times { start, read, write: written?.iter().sum(), writers, ..times }, reports))
    })?;
    bar.finish_and_clear();
    Ok((Times { all: start.elapsed(), frames: request.jobs.len(), ..times }, reports))
}

fn progress(frames: usize) -> ProgressBar {
    if frames < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {eta} left");
    ProgressBar::new(frames as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
