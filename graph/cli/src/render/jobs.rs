//! The frames that `render` makes, and the files of each.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use afterimage_media::film::{Film, is_film};
use afterimage_media::sequence::{FrameFiles, split_layer};
use afterimage_media::{Source, sequence};

use super::target::Target;
use crate::args::RenderArgs;
use crate::args::files::MissingFrames;
use crate::failure::Failure;
use crate::frame_ranges::ranges;
use crate::terminal::note;

/// The inputs and the files of one frame.
pub(super) struct Job {
    /// The pipeline's inputs and their files.
    pub(super) sources: Vec<(String, Source)>,
    pub(super) frame: Option<u32>,
    /// One file for each target.
    pub(super) out: Vec<PathBuf>,
    /// True if the files are written; otherwise the frame is rendered for the state of later ones only.
    pub(super) is_written: bool,
    /// The inputs whose file is missing; a source stands for it.
    pub(super) missing: Vec<String>,
}

/// The films of inputs, by the names of the inputs.
pub(super) type Films = BTreeMap<String, Film>;

/// Opens the films among the files of inputs.
pub(super) fn films(files: &[(String, String)]) -> Result<Films, Failure> {
    let mut films = Films::new();
    for (name, file) in files {
        let (path, layer) = split_layer(file);
        if is_film(path) {
            FrameFiles::new(file)?;
            films.insert(name.clone(), Film::open(&Source { path: path.into(), layer })?);
        }
    }
    Ok(films)
}

/// The files of all frames.
pub(super) struct NumberedFiles {
    /// The files of all inputs, by their names.
    files: Vec<(String, FrameFiles)>,
    /// The replacement of a missing frame.
    missing: MissingFrames,
    /// Number of frames of the shortest film.
    film_frames: Option<u32>,
    /// The frame with which a sequence without files begins, if it is known.
    pub(super) start: Option<u32>,
}

impl NumberedFiles {
    pub(super) fn new(files: &[(String, String)], missing: MissingFrames, films: &Films) -> Result<Self, Failure> {
        let of = |(name, file): &(String, String)| Ok((name.clone(), FrameFiles::new(file)?));
        let film_frames = films.values().map(|film| film.times.frames() as u32).min();
        Ok(Self { files: files.iter().map(of).collect::<Result<_, Failure>>()?, missing, film_frames, start: None })
    }

    /// True if an input has a file.
    pub(super) fn has(&self, input: &str) -> bool {
        self.files.iter().any(|(name, _)| name == input)
    }

    /// Puts up to `count` frames, `step` apart, before the first job, which are rendered for their state only, back to
    /// the start of the sequence or of the shot. Returns the frame before the first one that is left, if there is one.
    pub(super) fn roll_back(
        &self,
        jobs: &mut Vec<Job>,
        count: u32,
        step: Option<u32>,
        cuts: &BTreeSet<u32>,
    ) -> Option<u32> {
        let mut rolled = self.jobs_before(jobs.first()?.frame?, step, cuts);
        let mut before: Vec<Job> = rolled.by_ref().take(count as usize).collect();
        before.reverse();
        jobs.splice(0..0, before);
        let is_known = !self.files.is_empty() || self.start.is_some();
        rolled.next().filter(|_| is_known)?.frame
    }

    /// The jobs before a frame, `step` apart, from the last to the start of the sequence or of the shot.
    pub(super) fn jobs_before(&self, frame: u32, step: Option<u32>, cuts: &BTreeSet<u32>) -> impl Iterator<Item = Job> {
        let mut first = frame;
        std::iter::from_fn(move || {
            first = first.checked_sub(step.unwrap_or(1)).filter(|_| !cuts.contains(&first))?;
            self.job(first)
        })
    }

    /// The job of a frame that is rendered for its state only; `None` if it has no file.
    pub(super) fn job(&self, frame: u32) -> Option<Job> {
        if self.files.is_empty() && self.start.is_some_and(|start| frame < start) {
            return None;
        }
        if self.film_frames.is_some_and(|count| !(1..=count).contains(&frame)) {
            return None;
        }
        let stand_in = self.missing.stand_in();
        let is_filled = stand_in.is_some() && self.film_frames.is_none() && !self.files.is_empty();
        if is_filled && !self.files.iter().any(|(_, files)| files.spans(frame)) {
            return None;
        }
        let (mut sources, mut missing) = (Vec::new(), Vec::new());
        for (name, files) in &self.files {
            let (source, is_there) = match stand_in {
                None => (files.find(frame)?, true),
                Some(stand_in) => files.find_filled(frame, stand_in)?,
            };
            missing.extend((!is_there).then(|| name.clone()));
            sources.push((name.clone(), source));
        }
        Some(Job { sources, frame: Some(frame), out: Vec::new(), is_written: false, missing })
    }
}

/// The images that are made from these files of inputs. Refuses options without effect: they are mistakes.
pub(super) fn with_inputs(
    args: &RenderArgs,
    files: Vec<(String, String)>,
    films: &Films,
    targets: &[Target],
) -> Result<Vec<Job>, Failure> {
    let (mut inputs, mut sources) = (Vec::new(), Vec::new());
    let mut missing: BTreeMap<Option<u32>, Vec<String>> = BTreeMap::new();
    // The first sequence has the frames that others are filled to.
    let mut of_first: Option<String> = None;
    for (name, file) in files {
        let film = films.get(&name);
        let frames = args.frames.as_deref().filter(|_| film.is_some() || sequence::is_numbered(&file));
        let (input, gaps) = match (film, args.reading.missing.stand_in()) {
            (Some(film), _) => (of_film(&file, film, frames)?, BTreeSet::new()),
            (None, None) => (sequence::Input::find(&file, frames)?, BTreeSet::new()),
            (None, Some(stand_in)) => sequence::Input::find_filled(&file, frames.or(of_first.as_deref()), stand_in)?,
        };
        if let (sequence::Input::Sequence(frames), None) = (&input, &of_first) {
            of_first = Some(ranges(&frames.iter().map(|(frame, _)| *frame).collect::<Vec<_>>()));
        }
        tell_missing(&name, &gaps, args.reading.missing);
        if args.frames.is_none() {
            tell_other_numbers(&file);
        }
        gaps.into_iter().for_each(|frame| missing.entry(Some(frame)).or_default().push(name.clone()));
        sources.push((name.clone(), input.sources().into_iter().collect()));
        inputs.push((name, input));
    }
    let is_numbered = |(_, input): &(String, sequence::Input)| matches!(input, sequence::Input::Sequence(_));
    if args.frames.is_some() && !inputs.iter().any(is_numbered) {
        return Err(idle_frames());
    }
    let (_, first) = inputs.iter().find(|input| is_numbered(input)).unwrap_or(&inputs[0]);
    let out = targets.iter().map(|target| outputs(first, target)).collect::<Result<Vec<_>, Failure>>()?;
    let of_frame = |index: usize| out.iter().map(|files| files[index].clone()).collect();
    let frames = first.sources().into_iter().enumerate();
    let mut jobs = Vec::new();
    for (index, (frame, _)) in frames {
        let sources = sources.iter().map(|(name, files)| Ok((name.clone(), source_at(files, frame, name)?)));
        let (sources, missing) = (sources.collect::<Result<_, Failure>>()?, missing.remove(&frame).unwrap_or_default());
        jobs.push(Job { sources, frame, out: of_frame(index), is_written: true, missing });
    }
    Ok(jobs)
}

/// The file of a target in each frame.
fn outputs(input: &sequence::Input, target: &Target) -> Result<Vec<PathBuf>, Failure> {
    match (input, &target.film) {
        (sequence::Input::Sequence(frames), Some(_)) => Ok(vec![target.file.clone().into(); frames.len()]),
        (sequence::Input::Single(_), Some(_)) => Err(no_frames(&target.file)),
        (sequence::Input::Sequence(frames), None) if target.is_standard_output() => match frames.len() {
            1 => Ok(vec![target.file.clone().into()]),
            _ => Err(Failure::user("standard output takes one image").hint("`--frames 7` renders one of a sequence")),
        },
        (input, None) => Ok(input.outputs(&target.file)?),
    }
}

fn no_frames(file: &str) -> Failure {
    Failure::user(format!("`{file}` is a film, which is made of frames, and here is one image"))
        .hint("name a sequence: `shot.####.exr`, or frames: `--frames 1-48`")
}

/// The frames of a film, which count from 1.
fn of_film(file: &str, film: &Film, frames: Option<&str>) -> Result<sequence::Input, Failure> {
    let count = film.times.frames() as u32;
    let wanted = frames.map(|text| sequence::parse_frames("--frames", text)).transpose()?;
    let wanted = wanted.unwrap_or_else(|| (1..=count).collect());
    if let Some(frame) = wanted.iter().find(|frame| !(1..=count).contains(*frame)) {
        return Err(Failure::user(format!("`{file}` has no frame {frame}: its frames are 1 to {count}")));
    }
    if !wanted.is_sorted() {
        return Err(Failure::user("`--frames`: a film is read from its beginning to its end")
            .hint("name its frames in ascending order"));
    }
    Ok(sequence::Input::Sequence(wanted.into_iter().map(|frame| (frame, Source::file(file))).collect()))
}

fn tell_missing(name: &str, frames: &BTreeSet<u32>, missing: MissingFrames) {
    if frames.is_empty() {
        return;
    }
    let gaps = ranges(&frames.iter().copied().collect::<Vec<_>>());
    let (frames, are) = if frames.len() == 1 { ("frame", "is") } else { ("frames", "are") };
    let instead = match missing {
        MissingFrames::Black => "black takes their place",
        _ => "the frame before takes their place",
    };
    note(&format!("note: {frames} {gaps} of input `{name}` {are} missing: {instead}"));
}

/// Notes numbered files beside a sequence that are no frames of it.
pub(crate) fn tell_other_numbers(file: &str) {
    const ENOUGH: usize = 6;
    let others = sequence::other_numbers(file);
    let named: Vec<String> = others.iter().take(ENOUGH).map(|name| format!("`{name}`")).collect();
    let more = others.len().checked_sub(ENOUGH + 1).map(|more| format!(", and {} more", more + 1));
    let (are, frames) = if others.len() == 1 { ("is", "frame") } else { ("are", "frames") };
    if !others.is_empty() {
        let (named, more) = (named.join(", "), more.unwrap_or_default());
        note(&format!("note: {named}{more} {are} no {frames} of `{file}`: its pattern writes numbers in another way"));
    }
}

fn idle_frames() -> Failure {
    Failure::user("`--frames` needs a numbered input")
        .hint("put a placeholder into the name, for example `shot.####.exr`")
}

/// The images of a pipeline without inputs: one, or the named frames.
pub(super) fn without_inputs(args: &RenderArgs, targets: &[Target]) -> Result<Vec<Job>, Failure> {
    let job = |frame, out| Job { sources: Vec::new(), frame, out, is_written: true, missing: Vec::new() };
    let Some(frames) = &args.frames else {
        let out = targets.iter().map(|target| match target.film {
            Some(_) => Err(no_frames(&target.file)),
            None => single(&target.file),
        });
        return Ok(vec![job(None, out.collect::<Result<_, _>>()?)]);
    };
    let patterns = targets.iter().map(|target| match target.film {
        Some(_) => Ok(None),
        None => pattern(&target.file).map(Some),
    });
    let patterns = patterns.collect::<Result<Vec<_>, _>>()?;
    let file = |(target, pattern): (&Target, &Option<sequence::Pattern>), frame| {
        pattern.as_ref().map_or_else(|| target.file.clone().into(), |pattern| pattern.at(frame))
    };
    let of_frame = |frame| targets.iter().zip(&patterns).map(|target| file(target, frame)).collect();
    Ok(sequence::parse_frames("--frames", frames)?.into_iter().map(|frame| job(Some(frame), of_frame(frame))).collect())
}

fn single(file: &str) -> Result<PathBuf, Failure> {
    match sequence::Pattern::parse(file)? {
        None => Ok(file.into()),
        Some(_) => Err(Failure::user(format!("{file}: the output is numbered, but no frames are named"))
            .hint("name them, for example `--frames 1-48`")),
    }
}

fn pattern(file: &str) -> Result<sequence::Pattern, Failure> {
    sequence::Pattern::parse(file)?.ok_or_else(|| {
        Failure::user(format!("{file}: frames need a numbered output"))
            .hint("write `out.####.png`, or leave `--frames` out")
    })
}

/// The file of an input in one frame; a single image is that of all frames.
fn source_at(files: &BTreeMap<Option<u32>, Source>, frame: Option<u32>, name: &str) -> Result<Source, Failure> {
    let source = files.get(&frame).or_else(|| files.get(&None)).cloned();
    source.ok_or_else(|| {
        // Without a number, the first input is one image, and so is each other.
        let frame = frame.map_or_else(String::new, |frame| format!(" {frame}"));
        Failure::user(format!("input `{name}` has no frame{frame}"))
            .hint("`--frames` names those that all inputs have; `--missing black` puts black in the place of others")
    })
}
