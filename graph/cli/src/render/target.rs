//! The files that `render` writes, and the output of the pipeline that each of them takes.

use afterimage_media::{ExrOptions, PngDepth, PngOptions};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::save::SaveOptions;

/// A file, or the files of a sequence, and the output that it takes.
pub(super) struct Target {
    /// The name of the output; `None` for the first that fits the file.
    pub(super) output: Option<String>,
    /// The file, with a placeholder for a sequence.
    pub(super) file: String,
    /// Whether it is a PNG.
    pub(super) png: bool,
    /// How it is written.
    pub(super) saving: SaveOptions,
}

/// The files of `-o FILE`, `-o FILE --output NAME` and `--output NAME=FILE`.
pub(super) fn targets(args: &RenderArgs) -> Result<Vec<Target>, Failure> {
    let mut named = Vec::new();
    let mut bare = Vec::new();
    for word in &args.outputs {
        match word.split_once('=') {
            Some((output, file)) => named.push((Some(output.to_owned()), file.to_owned())),
            None => bare.push(word.clone()),
        }
    }
    let first = match (&args.out, bare.as_slice()) {
        (Some(file), []) => Some((None, file.clone())),
        (Some(file), [output]) => Some((Some(output.clone()), file.clone())),
        (None, []) if !named.is_empty() => None,
        (None, []) => return Err(Failure::user("no file to write").hint("name it: `-o out.png`")),
        (_, [.., output]) => return Err(no_file(output)),
    };
    let all: Vec<(Option<String>, String)> = first.into_iter().chain(named).collect();
    different(&all)?;
    all.into_iter().map(|(output, file)| target(args, output, file)).collect()
}

fn no_file(output: &str) -> Failure {
    Failure::user(format!("no file is named for the output `{output}`"))
        .hint(format!("write `--output {output}=FILE` for each output"))
}

/// Refuses two outputs in one file, and one output in two: the latter would be written twice.
fn different(all: &[(Option<String>, String)]) -> Result<(), Failure> {
    for (index, (output, file)) in all.iter().enumerate() {
        let before = &all[..index];
        if before.iter().any(|(_, other)| other == file) {
            return Err(Failure::user(format!("two outputs go to the file `{file}`")).hint("name a file for each"));
        }
        if output.is_some() && before.iter().any(|(other, _)| other == output) {
            let output = output.as_deref().unwrap_or_default();
            return Err(Failure::user(format!("two files are named for the output `{output}`")).hint("name one"));
        }
    }
    Ok(())
}

fn target(args: &RenderArgs, output: Option<String>, file: String) -> Result<Target, Failure> {
    let ends_with = |ending: &str| file.to_lowercase().ends_with(ending);
    let png = ends_with(".png");
    if !png && !ends_with(".exr") {
        return Err(Failure::user(format!("`{file}` ends neither in `.png` nor in `.exr`"))
            .hint("`.png` takes an encoded output, `.exr` a linear one"));
    }
    Ok(Target { output, png, saving: save_options(args, png)?, file })
}

fn save_options(args: &RenderArgs, png: bool) -> Result<SaveOptions, Failure> {
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
