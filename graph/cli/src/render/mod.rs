//! `afterimage render`: images through a pipeline. Reading, rendering and writing overlap.

mod jobs;

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use afterimage_gpu::{FrameStep, InputImage, Session, Texels};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_plan::PlanOutput;
use indicatif::{ProgressBar, ProgressStyle};

use crate::args::RenderArgs;
use crate::cache;
use crate::device::{open, options_on};
use crate::failure::Failure;
use crate::output::choose_output;
use crate::pipeline::{facts, load_graph, plan_options, registry};
use crate::save::{SaveOptions, save};
use crate::terminal::note;
use crate::watch::watch;
use afterimage_media::{Metadata, Picture};
use jobs::{Job, jobs};

/// Frames between two stages: one in work and one that is ready.
const AHEAD: usize = 2;
/// PNG compression keeps a core busy, so images are written on a quarter of the cores, but on at most this many
/// threads: each has a frame in memory.
const MOST_WRITERS: usize = 4;

pub(crate) fn run(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.watch {
        watch(args, tables, || once(args, tables));
    }
    once(args, tables)
}

fn once(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.nodes)?;
    let graph = load_graph(&args.pipeline, &registry, &args.options)?;
    let facts = facts(&args.options)?;
    let saving = SaveOptions::new(args)?;
    let jobs = jobs(args, &graph)?;
    let bar = progress(jobs.len());
    let times = work(args, &jobs, (graph, facts), &saving, &bar)?;
    bar.finish_and_clear();
    if args.timings {
        note(&times.to_string());
    }
    Ok(())
}

fn progress(frames: usize) -> ProgressBar {
    if frames < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {eta} left");
    ProgressBar::new(frames as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The images of a job.
type Read = Result<Vec<(String, Picture)>, Failure>;

/// A rendered image.
struct Rendered {
    texels: Texels,
    output: PlanOutput,
    meta: Option<Metadata>,
    index: usize,
}

/// The time of each stage.
#[derive(Default)]
struct Times {
    /// Until the device is open; images are read at the same time.
    start: Duration,
    read: Duration,
    render: Duration,
    /// The sum over all writers.
    write: Duration,
    writers: usize,
    all: Duration,
    frames: usize,
    passes: Vec<(String, f64)>,
}

fn work(
    args: &RenderArgs,
    jobs: &[Job],
    (graph, facts): (Graph, Facts),
    saving: &SaveOptions,
    bar: &ProgressBar,
) -> Result<Times, Failure> {
    let start = Instant::now();
    let (read_to, read_from) = sync_channel::<Read>(AHEAD);
    let (write_to, write_from) = sync_channel::<Rendered>(AHEAD);
    let writers = std::thread::available_parallelism().map_or(1, |cores| cores.get() / 4).clamp(1, MOST_WRITERS);
    let mut times = std::thread::scope(|scope| {
        let reader = scope.spawn(move || read_all(jobs, &read_to));
        let queue = Arc::new(Queue { from: Mutex::new(write_from), failed: AtomicBool::new(false) });
        let spawn = |_| {
            let queue = queue.clone();
            scope.spawn(move || write_all(jobs, saving, &queue, bar))
        };
        let writing: Vec<_> = (0..writers).map(spawn).collect();
        drop(queue);
        let rendered = render_all(args, jobs, (graph, facts), read_from, write_to);
        let read = reader.join().expect("the reader returns its errors");
        let written = writing.into_iter().map(|writer| writer.join().expect("a writer returns its errors"));
        let written = written.collect::<Result<Vec<Duration>, _>>();
        let rendered = rendered?;
        Ok::<_, Failure>(Times { read, write: written?.iter().sum(), writers, frames: jobs.len(), ..rendered })
    })?;
    times.all = start.elapsed();
    Ok(times)
}

fn read_job(job: &Job) -> Read {
    job.sources.iter().map(|(name, source)| Ok((name.clone(), afterimage_media::read(source)?))).collect()
}

fn read_all(jobs: &[Job], to: &SyncSender<Read>) -> Duration {
    let mut busy = Duration::ZERO;
    for job in jobs {
        let start = Instant::now();
        let pictures = read_job(job);
        busy += start.elapsed();
        let failed = pictures.is_err();
        // A receiver that is gone has failed and reports the error.
        if to.send(pictures).is_err() || failed {
            break;
        }
    }
    busy
}

/// Opens the device and renders what is read. The reader and the writers end with it; the device is freed while the
/// last image is written.
fn render_all(
    args: &RenderArgs,
    jobs: &[Job],
    (graph, facts): (Graph, Facts),
    from: Receiver<Read>,
    to: SyncSender<Rendered>,
) -> Result<Times, Failure> {
    let begun = Instant::now();
    let gpu = open(&args.device)?;
    let options = options_on(&gpu, plan_options(&args.plan), &args.device.arithmetic);
    let known_pipelines = cache::pipelines(&gpu);
    let mut session = Session::with_pipeline_cache(&gpu, graph, facts, options, &known_pipelines);
    let mut times = Times { start: begun.elapsed(), ..Times::default() };
    let mut said = Vec::new();
    for (index, pictures) in from.iter().enumerate() {
        let pictures = pictures?;
        for note_text in pictures.iter().flat_map(|(_, picture)| &picture.notes) {
            if !said.contains(note_text) {
                note(&format!("note: {note_text}"));
                said.push(note_text.clone());
            }
        }
        let start = Instant::now();
        let rendered = render_one(args, &mut session, pictures, step(args, jobs, index), index)?;
        times.render += start.elapsed();
        if index == 0 {
            cache::keep_pipelines(&mut session, &known_pipelines);
        }
        if args.timings && index == 0 {
            times.passes = time_passes(&mut session, jobs)?;
        }
        // A writer that is gone has failed and reports the error.
        if to.send(rendered).is_err() {
            break;
        }
    }
    // Everything is rendered: the writers may end before the device is freed.
    drop(to);
    Ok(times)
}

/// The position of a frame of a sequence in time, by its number.
fn step(args: &RenderArgs, jobs: &[Job], index: usize) -> FrameStep {
    let frames = jobs[index].frame.zip(index.checked_sub(1).and_then(|i| jobs[i].frame));
    let dt = frames.map_or(0.0, |(now, before)| now.saturating_sub(before) as f32 / args.fps);
    let time = jobs[index].frame.map_or(0.0, |frame| frame as f32 / args.fps);
    FrameStep { time, dt, reset: index == 0 }
}

fn render_one(
    args: &RenderArgs,
    session: &mut Session,
    pictures: Vec<(String, Picture)>,
    step: FrameStep,
    index: usize,
) -> Result<Rendered, Failure> {
    render_frame(args, session, &pictures, step)?;
    // The images are uploaded: their memory is freed while the GPU works.
    let meta = pictures.into_iter().next().map(|(_, picture)| picture.meta);
    let output = choose_output(session.plan(), args.output.as_deref(), SaveOptions::is_png(&args.out))?;
    let texels = session.output(&output.name)?;
    Ok(Rendered { texels, output, meta, index })
}

fn render_frame(
    args: &RenderArgs,
    session: &mut Session,
    pictures: &[(String, Picture)],
    step: FrameStep,
) -> Result<(), Failure> {
    let images = feed(session, pictures)?;
    let (width, height) = args.size.unwrap_or((1920, 1080));
    let size = images.first().map_or(Size::new(width, height), |image| image.desc.size);
    Ok(session.render(size, &images, step)?)
}

/// Uploads the images of a frame.
fn feed(session: &mut Session, pictures: &[(String, Picture)]) -> Result<Vec<InputImage>, Failure> {
    let upload = |(name, picture): &(String, Picture)| {
        session.gpu().check_fits(picture.desc())?;
        Ok(session.feed(name, picture.desc(), picture.bytes())?)
    };
    pictures.iter().map(upload).collect()
}

/// GPU milliseconds of each pass, from a second rendering of the first frame.
fn time_passes(session: &mut Session, jobs: &[Job]) -> Result<Vec<(String, f64)>, Failure> {
    let Some(first) = jobs.first() else { return Ok(Vec::new()) };
    let images = feed(session, &read_job(first)?)?;
    let times = session.pass_times_once(&images, FrameStep::FIRST)?;
    let passes = session.plan().recording.passes.iter();
    Ok(passes.map(|pass| pass.label.clone()).zip(times).collect())
}

/// Shared by the writers: the rendered images, and whether a writer has failed, so that the others stop.
struct Queue {
    from: Mutex<Receiver<Rendered>>,
    failed: AtomicBool,
}

impl Queue {
    /// The next image; `None` after the last one, or if another writer has failed.
    fn next(&self) -> Option<Rendered> {
        let next = self.from.lock().expect("no writer panics with the lock").recv().ok();
        next.filter(|_| !self.failed.load(Ordering::Relaxed))
    }
}

fn write_all(jobs: &[Job], saving: &SaveOptions, queue: &Queue, bar: &ProgressBar) -> Result<Duration, Failure> {
    let mut busy = Duration::ZERO;
    while let Some(rendered) = queue.next() {
        let start = Instant::now();
        let path: &Path = &jobs[rendered.index].out;
        let saved = save(path, &rendered.texels, rendered.output.state, rendered.meta, saving);
        queue.failed.fetch_or(saved.is_err(), Ordering::Relaxed);
        saved?;
        busy += start.elapsed();
        bar.inc(1);
    }
    Ok(busy)
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |time: Duration| time.as_secs_f64() * 1e3 / self.frames.max(1) as f64;
        let frames = if self.frames == 1 { "1 frame".to_owned() } else { format!("{} frames", self.frames) };
        writeln!(f, "{frames} in {:.3} s; milliseconds a frame:", self.all.as_secs_f64())?;
        let write = ms(self.write) / self.writers.max(1) as f64;
        writeln!(f, "  read {:.1}, render {:.1}, write {write:.1}", ms(self.read), ms(self.render))?;
        let writers = if self.writers > 1 { format!("; {} threads write", self.writers) } else { String::new() };
        writeln!(f, "  the device opened in {:.1}{writers}", self.start.as_secs_f64() * 1e3)?;
        for (label, ms) in &self.passes {
            writeln!(f, "  {ms:8.4} ms on the GPU: {label}")?;
        }
        Ok(())
    }
}
