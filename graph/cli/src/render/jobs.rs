//! The frames that `render` makes, and the files of each.

use std::collections::BTreeSet;
use std::path::PathBuf;

use afterimage_media::{FileError, Source, sequence};

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
    /// Whether the files are written; otherwise the frame is rendered for the state of later ones only.
    pub(super) is_written: bool,
    /// The inputs whose file is missing; a source stands for it.
    pub(super) missing: Vec<String>,
}

/// The files of all frames.
pub(super) struct NumberedFiles {
    /// The files of all inputs, by their names.
    pub(super) files: Vec<(String, String)>,
    /// What takes the place of a missing frame.
    pub(super) missing: MissingFrames,
    /// The frame with which a sequence without files begins, if it is known.
    pub(super) start: Option<u32>,
}

impl NumberedFiles {
    /// Puts up to `count` frames, `step` apart, before the first job, which are rendered for their state only, back to
    /// the start of the sequence or of the shot. Returns the frame before the first one that is left, if there is one.
    pub(super) fn roll_back(&self, jobs: &mut Vec<Job>, count: u32, step: Option<u32>, cuts: &[u32]) -> Option<u32> {
        let mut first = jobs.first()?.frame?;
        for left in (0..=count).rev() {
            let before = first.checked_sub(step.unwrap_or(1)).filter(|_| !cuts.contains(&first))?;
            let job = self.job(before)?;
            if left == 0 {
                let is_known = !self.files.is_empty() || self.start.is_some();
                return is_known.then_some(before);
            }
            jobs.insert(0, job);
            first = before;
        }
        None
    }

    /// The job of a frame that is rendered for its state only; `None` if it has no file.
    pub(super) fn job(&self, frame: u32) -> Option<Job> {
        if self.files.is_empty() && self.start.is_some_and(|start| frame < start) {
            return None;
        }
        let (mut sources, mut missing) = (Vec::new(), Vec::new());
        for (name, file) in &self.files {
            let frames = frame.to_string();
            let frames = sequence::is_numbered(file).then_some(frames.as_str());
            let (found, gaps) = find(file, frames, self.missing).ok()?;
            let (_, source) = found.sources().into_iter().next()?;
            // Beyond the last frame a sequence has ended.
            if gaps.contains(&frame) && !has_later(file, frame) {
                return None;
            }
            missing.extend(gaps.contains(&frame).then(|| name.clone()));
            sources.push((name.clone(), source));
        }
        Some(Job { sources, frame: Some(frame), out: Vec::new(), is_written: false, missing })
    }
}

/// The images that are made from these files of inputs. Refuses options without effect: they are mistakes.
pub(super) fn with_inputs(
    args: &RenderArgs,
    files: Vec<(String, String)>,
    targets: &[Target],
) -> Result<Vec<Job>, Failure> {
    let mut inputs = Vec::new();
    let mut missing = Vec::new();
    for (name, file) in files {
        let frames = args.frames.as_deref().filter(|_| sequence::is_numbered(&file));
        let (input, gaps) = find(&file, frames, args.reading.missing)?;
        tell_missing(&name, &gaps, args.reading.missing);
        if args.frames.is_none() {
            tell_other_numbers(&file);
        }
        missing.extend(gaps.into_iter().map(|frame| (name.clone(), frame)));
        inputs.push((name, input));
    }
    let is_numbered = |(_, input): &(String, sequence::Input)| matches!(input, sequence::Input::Sequence(_));
    if args.frames.is_some() && !inputs.iter().any(is_numbered) {
        return Err(idle_frames());
    }
    let (_, first) = inputs.iter().find(|input| is_numbered(input)).unwrap_or(&inputs[0]);
    let out = targets.iter().map(|target| first.outputs(&target.file)).collect::<Result<Vec<_>, _>>()?;
    let of_frame = |index: usize| out.iter().map(|files| files[index].clone()).collect();
    let frames = first.sources().into_iter().enumerate();
    let mut jobs = Vec::new();
    for (index, (frame, _)) in frames {
        let lacks = missing.iter().filter(|(_, gap)| Some(*gap) == frame).map(|(name, _)| name.clone()).collect();
        jobs.push(Job { missing: lacks, ..job(&inputs, index, frame, of_frame(index))? });
    }
    Ok(jobs)
}

/// The files of a name, and the frames among them that are missing, for which other files stand.
fn find(
    file: &str,
    frames: Option<&str>,
    missing: MissingFrames,
) -> Result<(sequence::Input, BTreeSet<u32>), FileError> {
    match missing {
        MissingFrames::Error => Ok((sequence::Input::find(file, frames)?, BTreeSet::new())),
        MissingFrames::Hold | MissingFrames::Black => sequence::Input::find_filled(file, frames),
    }
}

/// Whether a sequence has a frame after this one.
fn has_later(file: &str, frame: u32) -> bool {
    let input = sequence::Input::find_filled(file, None);
    let last = input.ok().and_then(|(input, _)| input.sources().last().and_then(|(frame, _)| *frame));
    last.is_some_and(|last| last > frame)
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

fn job(
    inputs: &[(String, sequence::Input)],
    index: usize,
    frame: Option<u32>,
    out: Vec<PathBuf>,
) -> Result<Job, Failure> {
    let source = |(name, input): &(String, _)| Ok((name.clone(), source_at(input, index, frame, name)?));
    let sources = inputs.iter().map(source).collect::<Result<Vec<_>, Failure>>()?;
    Ok(Job { sources, frame, out, is_written: true, missing: Vec::new() })
}

/// The images of a pipeline without inputs: one, or the named frames.
pub(super) fn without_inputs(args: &RenderArgs, targets: &[Target]) -> Result<Vec<Job>, Failure> {
    let job = |frame, out| Job { sources: Vec::new(), frame, out, is_written: true, missing: Vec::new() };
    let Some(frames) = &args.frames else {
        let out = targets.iter().map(|target| single(&target.file)).collect::<Result<_, _>>()?;
        return Ok(vec![job(None, out)]);
    };
    let patterns = targets.iter().map(|target| pattern(&target.file)).collect::<Result<Vec<_>, _>>()?;
    let of_frame = |frame| patterns.iter().map(|pattern| pattern.at(frame)).collect();
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
fn source_at(input: &sequence::Input, index: usize, frame: Option<u32>, name: &str) -> Result<Source, Failure> {
    match input {
        sequence::Input::Single(source) => Ok(source.clone()),
        sequence::Input::Sequence(frames) => match frames.iter().find(|(number, _)| Some(*number) == frame) {
            Some((_, source)) => Ok(source.clone()),
            None => {
                let frame = frame.map_or_else(|| index.to_string(), |frame| frame.to_string());
                Err(Failure::user(format!("input `{name}` has no frame {frame}")))
            }
        },
    }
}
