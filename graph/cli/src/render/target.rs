//! The files that `render` writes, and the output of the pipeline that each of them takes.

use afterimage_media::Alpha;

use crate::args::{AlphaChoice, RenderArgs};
use crate::failure::Failure;
use crate::save::{FileFormat, SaveOptions};

/// A file, or the files of a sequence, and the output that it takes.
pub(super) struct Target {
    /// The name of the output; `None` for the first that fits the file.
    pub(super) output: Option<String>,
    /// The file, with a placeholder for a sequence.
    pub(super) file: String,
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
    Ok(Target { output, saving: save_options(args, &file)?, file })
}

fn save_options(args: &RenderArgs, file: &str) -> Result<SaveOptions, Failure> {
    let format = FileFormat::of(file).ok_or_else(|| unknown_format(file))?;
    Ok(SaveOptions {
        bits: bits(format, args.depth)?,
        dither: !args.no_dither,
        alpha: match args.alpha {
            AlphaChoice::Auto => Alpha::WhereNeeded,
            AlphaChoice::Keep => Alpha::Keep,
            AlphaChoice::Drop => Alpha::Drop,
        },
        quality: args.quality,
        ..SaveOptions::plain(format)
    })
}

fn unknown_format(name: &str) -> Failure {
    if name.to_lowercase().ends_with(".avif") {
        return Failure::user(format!("{name}: this build of the program does not write AVIF"))
            .hint("build it with `--features avif`, or write a `.png` file");
    }
    Failure::user(format!("`{name}` ends in none of `.png`, `.jpg`, `.avif` and `.exr`"))
        .hint("`.png`, `.jpg` and `.avif` take an encoded output, `.exr` a linear one")
}

/// The bits of a channel.
fn bits(format: FileFormat, asked: Option<u8>) -> Result<u32, Failure> {
    let (name, known): (&str, &[u8]) = match format {
        FileFormat::Png => ("a PNG", &[8, 16]),
        FileFormat::Jpeg => ("a JPEG", &[8]),
        #[cfg(feature = "avif")]
        FileFormat::Avif => ("an AVIF", &[10]),
        FileFormat::Exr => ("an EXR", &[16, 32]),
    };
    let bits = asked.unwrap_or(known[0]);
    if known.contains(&bits) {
        return Ok(bits.into());
    }
    let known: Vec<String> = known.iter().map(u8::to_string).collect();
    Err(Failure::user(format!("{name} has {} bits, not {bits}", known.join(" or "))))
}
