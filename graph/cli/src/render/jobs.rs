//! The images and frames that `render` makes, and the files that they are made from.

use std::path::{Path, PathBuf};

use afterimage_graph::check::Graph;

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::pipeline::split;
use afterimage_media::{Source, sequence};

/// The inputs and the output of one image.
pub(super) struct Job {
    /// The pipeline's inputs and their files.
    pub(super) sources: Vec<(String, Source)>,
    pub(super) frame: Option<u32>,
    pub(super) out: PathBuf,
}

pub(super) fn jobs(args: &RenderArgs, graph: &Graph) -> Result<Vec<Job>, Failure> {
    let named = input_files(args, graph)?;
    let mut inputs = Vec::new();
    for (name, file) in named {
        inputs.push((name, sequence::Input::find(&file, args.frames.as_deref().filter(|_| is_pattern(&file)))?));
    }
    let Some((_, first)) = inputs.first() else { return without_inputs(args) };
    refuse_unused_options(args, &inputs)?;
    let outs = first.outputs(&args.out)?;
    let frames = first.sources();
    let mut jobs = Vec::new();
    for (index, ((frame, _), out)) in frames.into_iter().zip(outs).enumerate() {
        let sources = inputs.iter().map(|(name, input)| Ok((name.clone(), source_at(input, index, frame, name)?)));
        let sources: Vec<(String, Source)> = sources.collect::<Result<_, Failure>>()?;
        refuse_overwriting(&sources, &out)?;
        jobs.push(Job { sources, frame, out });
    }
    Ok(jobs)
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

/// Refuses options without effect: they are mistakes.
fn refuse_unused_options(args: &RenderArgs, inputs: &[(String, sequence::Input)]) -> Result<(), Failure> {
    if args.size.is_some() {
        return Err(Failure::user(
            "`--size` is for pipelines without inputs; here the output has the size of the input",
        )
        .hint("leave it out, or scale the input"));
    }
    let is_numbered = |(_, input): &(String, sequence::Input)| matches!(input, sequence::Input::Sequence(_));
    if args.frames.is_some() && !inputs.iter().any(is_numbered) {
        return Err(Failure::user("`--frames` needs a numbered input")
            .hint("put a placeholder into the name, for example `shot.####.exr`"));
    }
    Ok(())
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

/// The files that the command line gives to the pipeline's inputs.
fn input_files(args: &RenderArgs, graph: &Graph) -> Result<Vec<(String, String)>, Failure> {
    let known: Vec<&str> = graph.inputs.iter().map(|input| input.name.as_str()).collect();
    let mut files = Vec::new();
    for input in &args.inputs {
        let (name, file) = split(input, "--input")?;
        if !known.contains(&name.as_str()) {
            let hint = if known.is_empty() { "it has none".into() } else { format!("it has `{}`", known.join("`, `")) };
            return Err(Failure::user(format!("the pipeline has no input `{name}`")).hint(hint));
        }
        files.push((name, file));
    }
    let given = |name: &str, files: &[(String, String)]| files.iter().any(|(known, _)| known == name);
    if let Some(file) = &args.input {
        let free = known.iter().find(|name| !given(name, &files));
        let free =
            free.ok_or_else(|| Failure::user("the pipeline takes no further image").hint("leave the input file out"))?;
        files.insert(0, ((*free).to_owned(), file.clone()));
    }
    match graph.inputs.iter().find(|input| !input.optional && !given(&input.name, &files)) {
        None => Ok(files),
        Some(input) => Err(Failure::user(format!("the pipeline needs an image for its input `{}`", input.name))
            .hint(format!("name a file after the pipeline, or `--input {}=FILE`", input.name))),
    }
}
