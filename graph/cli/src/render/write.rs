//! The last stage of `render`: images are written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use afterimage_gpu::Texels;
use afterimage_graph::color::Colorimetry;
use afterimage_media::Metadata;
use afterimage_media::film::FilmWriter;
use afterimage_plan::PlanOutput;

use super::jobs::Job;
use super::read::read_options;
use super::request::{Request, is_picture};
use super::target::{FilmTarget, STANDARD};
use crate::args::files::MissingFrames;
use crate::failure::Failure;
use crate::progress::Bar;
use crate::save::{ImageInfo, Original, save};
use crate::terminal::note;

/// A rendered image.
pub(super) struct Rendered {
    /// `None` if its file is written already.
    pub(super) texels: Option<Texels>,
    /// The image to which its gain map leads, if it has one.
    pub(super) hdr: Option<(PlanOutput, Texels)>,
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
    /// Messages about files that were printed.
    printed: Mutex<Vec<String>>,
}

/// The outcome of each file: its job, and the error if it was not written.
pub(super) type Written = Mutex<Vec<(usize, Option<String>)>>;

impl Queue {
    pub(super) fn new(from: Receiver<Rendered>) -> Self {
        Self { from: Mutex::new(from), failed: AtomicBool::new(false), printed: Mutex::default() }
    }

    /// Prints notes that were not printed before.
    fn print_notes(&self, notes: &[String]) {
        let mut printed = self.printed.lock().expect("no writer panics with the lock");
        for text in notes {
            if !printed.contains(text) {
                note(&format!("note: {text}"));
                printed.push(text.clone());
            }
        }
    }

    /// The next image; `None` after the last one, or if another writer has failed.
    fn next(&self) -> Option<Rendered> {
        let next = self.from.lock().expect("no writer panics with the lock").recv().ok();
        next.filter(|_| !self.failed.load(Ordering::Relaxed))
    }
}

/// The file whose layers a frame keeps: that of the first image.
pub(super) fn original(request: &Request<'_>, job: &Job) -> Option<Original> {
    let is_image = |name: &str| request.inputs.iter().any(|input| input.name == name && is_picture(input));
    let (name, source) = job.sources.iter().find(|(name, _)| is_image(name))?;
    if request.films.contains_key(name) || source.path.as_path() == Path::new(STANDARD) {
        return None;
    }
    let is_black = request.args.reading.missing == MissingFrames::Black && job.missing.contains(name);
    let original = || Original { source: source.clone(), reading: read_options(request, name) };
    (!request.args.exr.drop_layers && !is_black).then(original)
}

/// Writes what the queue holds; returns the time that it takes.
pub(super) fn write_all(
    request: &Request<'_>,
    queue: &Queue,
    written: &Written,
    bar: &Bar,
) -> Result<Duration, Failure> {
    let mut busy = Duration::ZERO;
    let mut films = OpenFilms::default();
    while let Some(rendered) = queue.next() {
        let start = Instant::now();
        let path = &request.jobs[rendered.index].out[rendered.target];
        let frame = request.jobs[rendered.index].frame.unwrap_or(0);
        let original = original(request, &request.jobs[rendered.index]);
        let hdr = rendered.hdr.map(|(output, texels)| (texels, output.colorimetry));
        let stated = ImageInfo { meta: rendered.meta, frame, original, hdr, ..ImageInfo::of(&rendered.output) };
        let saving = &request.targets[rendered.target].saving;
        let saved = match (&request.targets[rendered.target].film, rendered.texels) {
            (_, None) => Ok(Vec::new()),
            (Some(film), Some(texels)) => {
                let colors = &stated.colorimetry;
                films.write(request, path, film, (colors, rendered.index), &texels)
            }
            (None, Some(texels)) => save(path, &texels, &stated, saving),
        };
        let saved = saved.map(|notes| queue.print_notes(&notes));
        let error = saved.as_ref().err().map(Failure::message);
        // A frame of a film is there when the film is.
        if error.is_some() || request.targets[rendered.target].film.is_none() {
            written.lock().expect("no writer panics with the lock").push((rendered.index, error));
        }
        match saved {
            Err(failure) if request.args.keep_going => failure.print(),
            saved => {
                queue.failed.fetch_or(saved.is_err(), Ordering::Relaxed);
                saved?;
            }
        }
        busy += start.elapsed();
        // The bar counts frames; the last target ends one.
        if rendered.target + 1 == request.targets.len() {
            bar.advance(&format!("frame {frame}"));
        }
    }
    let start = Instant::now();
    films.finish(request, written)?;
    Ok(busy + start.elapsed())
}

/// The films that are written, by their files, and the jobs of their frames.
#[derive(Default)]
struct OpenFilms(BTreeMap<PathBuf, (FilmWriter, Vec<usize>)>);

impl OpenFilms {
    /// Writes a frame of a film; the first one begins it. Returns sentences about what is changed.
    fn write(
        &mut self,
        request: &Request<'_>,
        path: &Path,
        FilmTarget { preset, more }: &FilmTarget,
        (colors, index): (&Colorimetry, usize),
        texels: &Texels,
    ) -> Result<Vec<String>, Failure> {
        let mut notes = Vec::new();
        if !self.0.contains_key(path) {
            let size = (texels.desc.size.width, texels.desc.size.height);
            let (times, sound) = request.timeline();
            let (film, changed) = FilmWriter::create(path, size, colors, (*preset, more), times, sound.as_ref())?;
            self.0.insert(path.to_owned(), (film, Vec::new()));
            notes = changed;
        }
        let (film, jobs) = self.0.get_mut(path).expect("it is open");
        film.write(request.index_in_film(index), &texels.to_floats())?;
        jobs.push(index);
        Ok(notes)
    }

    /// Ends the films that have all frames; others leave nothing.
    fn finish(self, request: &Request<'_>, written: &Written) -> Result<(), Failure> {
        let all = request.jobs.iter().filter(|job| job.is_written).count();
        for (film, jobs) in self.0.into_values() {
            if jobs.len() == all || request.args.keep_going {
                film.finish()?;
                let mut written = written.lock().expect("no writer panics with the lock");
                written.extend(jobs.into_iter().map(|index| (index, None)));
            }
        }
        Ok(())
    }
}
