//! The images and frames that `render` makes, the files that they are made from, and how they are written.

use std::path::{Path, PathBuf};

use afterimage_graph::check::{Graph, GraphInput};
use afterimage_media::{ExrOptions, PngDepth, PngOptions, Source, sequence};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::save::SaveOptions;

/// The inputs and the output of one image.
pub(super) struct Job {
    /// The pipeline's inputs and their files.
    pub(super) sources: Vec<(String, Source)>,
    pub(super) frame: Option<u32>,
    pub(super) out: PathBuf,
}

/// What `render` makes, from the command line and the pipeline's graph.
pub(super) struct Request<'a> {
    /// The command line.
    pub(super) args: &'a RenderArgs,
    /// How the images are written.
    pub(super) saving: SaveOptions,
    /// The images in order.
    pub(super) jobs: Vec<Job>,
    /// Whether they are written as PNG.
    pub(super) png: bool,
    /// The frames that begin a new shot.
    pub(super) cuts: Vec<u32>,
    /// The pipeline's inputs.
    pub(super) inputs: Vec<GraphInput>,
}

impl<'a> Request<'a> {
    /// `named` are the files of `--input`, by the name of the input.
    pub(super) fn new(args: &'a RenderArgs, graph: &Graph, named: Vec<(String, String)>) -> Result<Self, Failure> {
        let png = ends_with(&args.out, ".png");
        let saving = save_options(args, png)?;
        let files = input_files(args, graph, named)?;
        let jobs = if files.is_empty() { without_inputs(args) } else { with_inputs(args, files) }?;
        let cuts = cuts(args, &jobs)?;
        Ok(Self { args, saving, jobs, png, cuts, inputs: graph.inputs.clone() })
    }
}

/// The frames of `--cut`. Each must be a frame of the sequence.
fn cuts(args: &RenderArgs, jobs: &[Job]) -> Result<Vec<u32>, Failure> {
    let Some(text) = &args.cut else { return Ok(Vec::new()) };
    let cuts = sequence::parse_frames(text)?;
    let is_missing = |cut: &&u32| !jobs.iter().any(|job| job.frame == Some(**cut));
    match cuts.iter().find(is_missing) {
        None => Ok(cuts),
        Some(cut) => Err(Failure::user(format!("`--cut`: the sequence has no frame {cut}"))
            .hint("a cut is a frame that is rendered, as `--frames` or the files name it")),
    }
}

fn save_options(args: &RenderArgs, png: bool) -> Result<SaveOptions, Failure> {
    if !png && !ends_with(&args.out, ".exr") {
        return Err(Failure::user(format!("`{}` ends neither in `.png` nor in `.exr`", args.out))
            .hint("`.png` takes an encoded output, `.exr` a linear one"));
    }
    let deep = match (png, args.depth) {
        (true, None | Some(8)) | (false, None | Some(16)) => false,
        (true, Some(16)) | (false, Some(32)) => true,
        (true, Some(depth)) => return Err(Failure::user(format!("a PNG has 8 or 16 bits, not {depth}"))),
        (false, Some(depth)) => return Err(Failure::user(format!("an EXR has 16 or 32 bits, not {depth}"))),
    };
    let depth = if png && deep { PngDepth::Sixteen } else { PngDepth::Eight };
    let dither = (!args.no_dither).then_some(0);
    Ok(SaveOptions {
        png: PngOptions { depth, dither, ..PngOptions::default() },
        exr: ExrOptions { float: !png && deep, ..ExrOptions::default() },
    })
}

fn ends_with(name: &str, ending: &str) -> bool {
    name.to_lowercase().ends_with(ending)
}

/// The images that are made from these files of inputs. Refuses options without effect: they are mistakes.
fn with_inputs(args: &RenderArgs, files: Vec<(String, String)>) -> Result<Vec<Job>, Failure> {
    let find = |(name, file): (String, String)| {
        let frames = args.frames.as_deref().filter(|_| is_pattern(&file));
        Ok((name, sequence::Input::find(&file, frames)?))
    };
    let inputs = files.into_iter().map(find).collect::<Result<Vec<_>, Failure>>()?;
    if args.size.is_some() {
        return Err(idle_size());
    }
    let is_numbered = |(_, input): &(String, sequence::Input)| matches!(input, sequence::Input::Sequence(_));
    if args.frames.is_some() && !inputs.iter().any(is_numbered) {
        return Err(idle_frames());
    }
    let (_, first) = &inputs[0];
    let images = first.sources().into_iter().zip(first.outputs(&args.out)?).enumerate();
    images.map(|(index, ((frame, _), out))| job(&inputs, index, frame, out)).collect()
}

fn idle_size() -> Failure {
    Failure::user("`--size` is for pipelines without inputs; here the output has the size of the input")
        .hint("leave it out, or scale the input")
}

fn idle_frames() -> Failure {
    Failure::user("`--frames` needs a numbered input")
        .hint("put a placeholder into the name, for example `shot.####.exr`")
}

fn job(inputs: &[(String, sequence::Input)], index: usize, frame: Option<u32>, out: PathBuf) -> Result<Job, Failure> {
    let source = |(name, input): &(String, _)| Ok((name.clone(), source_at(input, index, frame, name)?));
    let sources = inputs.iter().map(source).collect::<Result<Vec<_>, Failure>>()?;
    refuse_overwriting(&sources, &out)?;
    Ok(Job { sources, frame, out })
}

/// The images of a pipeline without inputs: one, or the named frames.
fn without_inputs(args: &RenderArgs) -> Result<Vec<Job>, Failure> {
    let job = |frame, out| Job { sources: Vec::new(), frame, out };
    match (sequence::Pattern::parse(&args.out)?, &args.frames) {
        (None, None) => Ok(vec![job(None, args.out.clone().into())]),
        (Some(pattern), Some(frames)) => {
            Ok(sequence::parse_frames(frames)?.into_iter().map(|frame| job(Some(frame), pattern.at(frame))).collect())
        }
        (Some(_), None) => Err(Failure::user(format!("{}: the output is numbered, but no frames are named", args.out))
            .hint("name them, for example `--frames 1-48`")),
        (None, Some(_)) => Err(Failure::user(format!("{}: frames need a numbered output", args.out))
            .hint("write `out.####.png`, or leave `--frames` out")),
    }
}

/// Refuses an output that overwrites an input.
fn refuse_overwriting(sources: &[(String, Source)], out: &Path) -> Result<(), Failure> {
    let Ok(target) = std::fs::canonicalize(out) else { return Ok(()) };
    let same = |source: &&(String, Source)| std::fs::canonicalize(&source.1.path).is_ok_and(|path| path == target);
    match sources.iter().find(same) {
        None => Ok(()),
        Some((name, _)) => Err(Failure::user(format!("{}: this is the image of input `{name}`", out.display()))
            .hint("choose another name for the output")),
    }
}

fn is_pattern(file: &str) -> bool {
    sequence::Pattern::parse(file.split('#').next().unwrap_or(file)).is_ok_and(|p| p.is_some()) || file.contains('#')
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

/// The files that the command line gives to the pipeline's inputs; `files` are those with a name.
fn input_files(
    args: &RenderArgs,
    graph: &Graph,
    mut files: Vec<(String, String)>,
) -> Result<Vec<(String, String)>, Failure> {
    let known: Vec<&str> = graph.inputs.iter().map(|input| input.name.as_str()).collect();
    if let Some((name, _)) = files.iter().find(|(name, _)| !known.contains(&name.as_str())) {
        return Err(unknown_input(name, &known));
    }
    let given = |name: &str, files: &[(String, String)]| files.iter().any(|(known, _)| known == name);
    if let Some(file) = &args.input {
        let free = known.iter().find(|name| !given(name, &files)).ok_or_else(no_further_input)?;
        files.insert(0, ((*free).to_owned(), file.clone()));
    }
    match graph.inputs.iter().find(|input| !input.optional && !given(&input.name, &files)) {
        None => Ok(files),
        Some(input) => Err(missing_input(&input.name)),
    }
}

fn unknown_input(name: &str, known: &[&str]) -> Failure {
    let hint = if known.is_empty() { "it has none".into() } else { format!("it has `{}`", known.join("`, `")) };
    Failure::user(format!("the pipeline has no input `{name}`")).hint(hint)
}

fn no_further_input() -> Failure {
    Failure::user("the pipeline takes no further image").hint("leave the input file out")
}

fn missing_input(name: &str) -> Failure {
    Failure::user(format!("the pipeline needs an image for its input `{name}`"))
        .hint(format!("name a file after the pipeline, or `--input {name}=FILE`"))
}
