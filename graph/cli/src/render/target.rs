//! The files that `render` writes, and the output of the pipeline that each of them takes.

use std::path::Path;

use afterimage_graph::check::{Graph, GraphOutput};
use afterimage_graph::color::Transfer;
use afterimage_graph::diagnostic::list;
use afterimage_graph::image::ColorState;
use afterimage_media::film::{Preset, is_film};
use afterimage_media::sequence::Pattern;
use afterimage_media::{Alpha, Encoding, ForeignFormat, ImageFormat};

use crate::args::{AlphaChoice, RenderArgs};
use crate::failure::Failure;
pub(super) use crate::save::STANDARD;
use crate::save::{SaveOptions, is_color};

/// A file, or the files of a sequence, and the output that it takes.
pub(super) struct Target {
    /// The name of the output.
    pub(super) output: String,
    /// The file, with a placeholder for a sequence.
    pub(super) file: String,
    /// Properties of the file.
    pub(super) saving: SaveOptions,
    /// The film that the file is, if it is one.
    pub(super) film: Option<FilmTarget>,
    /// The HDR output to which the gain map of a JPEG leads.
    pub(super) gain_map: Option<String>,
}

/// The encoding of a film.
pub(super) struct FilmTarget {
    pub(super) preset: Preset,
    /// Further options of `ffmpeg`.
    pub(super) more: Vec<String>,
}

impl Target {
    pub(super) fn is_standard_output(&self) -> bool {
        self.file == STANDARD
    }
}

/// The files of `-o FILE`, `-o FILE --output NAME` and `--output NAME=FILE`.
pub(super) fn targets(args: &RenderArgs, graph: &Graph) -> Result<Vec<Target>, Failure> {
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
    let targets: Vec<Target> =
        all.into_iter().map(|(output, file)| target(args, graph, output.as_deref(), file)).collect::<Result<_, _>>()?;
    if args.video.is_some() && !targets.iter().any(|target| target.film.is_some()) {
        return Err(Failure::user("`--video` is for films, and none is written").hint("name one: `-o out.mov`"));
    }
    if args.gain_map.is_some() && !targets.iter().any(|target| target.gain_map.is_some()) {
        let error = Failure::user("`--gain-map` is for JPEG files, and none is written");
        return Err(error.hint("name one: `-o photo.jpg`"));
    }
    if args.openjd && targets.iter().any(Target::is_standard_output) {
        return Err(Failure::user("`--openjd` prints to standard output, and so does `-o -`").hint("name a file"));
    }
    if let Some(depth) = args.depth {
        check_depth(depth, &targets)?;
    }
    let is_idle = !targets.iter().any(|target| target.saving.encoding.format == ImageFormat::Exr);
    match args.exr.given().filter(|_| is_idle) {
        Some(option) => {
            Err(Failure::user(format!("`{option}` is for EXR files, and none is written")).hint("leave it out"))
        }
        None => Ok(targets),
    }
}

fn no_file(output: &str) -> Failure {
    Failure::user(format!("no file is named for the output `{output}`")).hint(match written_format(output) {
        Some(_) => format!("`-o {output}` names the file; `--output` names an output of the pipeline"),
        None => format!("write `--output {output}=FILE` for each output"),
    })
}

/// Refuses one output in two files: it would be written twice.
fn different(all: &[(Option<String>, String)]) -> Result<(), Failure> {
    for (index, (output, _)) in all.iter().enumerate() {
        let before = &all[..index];
        if output.is_some() && before.iter().any(|(other, _)| other == output) {
            let output = output.as_deref().unwrap_or_default();
            return Err(Failure::user(format!("two files are named for the output `{output}`")).hint("name one"));
        }
    }
    Ok(())
}

fn target(args: &RenderArgs, graph: &Graph, output: Option<&str>, file: String) -> Result<Target, Failure> {
    if is_film(&file) {
        return film(args, graph, output, file);
    }
    let format = match file == STANDARD {
        true => standard_format(graph, output)?,
        false => written_format(&file).ok_or_else(|| unknown_format(&file))?,
    };
    let has_codes = format.is_encoded() && !(format == ImageFormat::Tiff && args.depth == Some(32));
    let output = choose_output(graph, output, has_codes)?;
    let space = args.exr.output_space.filter(|_| is_color(output.state));
    if format == ImageFormat::Exr && args.exr.output_space != space && !args.exr.is_space_of_all_runs {
        return Err(no_light(output));
    }
    let color = graph.colors().at(output.source);
    let is_hdr = color.is_some_and(|color| matches!(color.colorimetry.transfer, Transfer::Pq | Transfer::Hlg));
    let mut saving = SaveOptions::plain(format);
    saving.encoding = Encoding {
        bits: bits(format, args.depth, is_hdr),
        dither: saving.encoding.dither.filter(|_| !args.no_dither && args.captured.is_none()),
        alpha: match args.alpha {
            _ if format == ImageFormat::Exr => Alpha::Keep,
            AlphaChoice::Auto if output.has_coverage => Alpha::WhereNeeded,
            AlphaChoice::Keep => Alpha::Keep,
            AlphaChoice::Auto | AlphaChoice::Drop => Alpha::Drop,
        },
        premultiplied: output.has_coverage || !graph.inputs.iter().any(|input| input.needs_alpha),
        quality: args.quality.unwrap_or(saving.encoding.quality),
        compression: args.exr.compression.unwrap_or_default(),
        primaries: space.map(|space| space.primaries),
        ..saving.encoding
    };
    let gain_map = args.gain_map.as_ref().filter(|_| format == ImageFormat::Jpeg);
    let gain_map = gain_map.map(|name| hdr_output(graph, name)).transpose()?;
    Ok(Target { output: output.name.clone(), file, saving, film: None, gain_map })
}

/// The output of a gain map.
fn hdr_output(graph: &Graph, name: &str) -> Result<String, Failure> {
    let output = choose_output(graph, Some(name), true)?;
    match graph.colors().at(output.source).map(|color| color.colorimetry.transfer) {
        Some(Transfer::Pq) => Ok(name.to_owned()),
        _ => Err(Failure::user(format!("output `{name}` is not PQ, and a gain map leads to an HDR image"))
            .hint("the built-in pipeline `hdr` has one of each: `-o photo.jpg --gain-map hdr`")),
    }
}

/// The format of standard output: PNG for an encoded output, EXR for another one.
fn standard_format(graph: &Graph, output: Option<&str>) -> Result<ImageFormat, Failure> {
    let is_encoded = match output {
        Some(name) => graph.outputs.iter().any(|known| known.name == name && known.state == ColorState::Encoded),
        None => graph.outputs.first().is_some_and(|first| first.state == ColorState::Encoded),
    };
    Ok(if is_encoded { ImageFormat::Png } else { ImageFormat::Exr })
}

/// A film of an encoded output.
fn film(args: &RenderArgs, graph: &Graph, output: Option<&str>, file: String) -> Result<Target, Failure> {
    if args.skip_existing {
        return Err(Failure::user(format!("`--skip-existing` is for numbered images, and `{file}` is one film"))
            .hint("`--frames` renders a part of a film to a film of its own"));
    }
    Pattern::parse(&file)?;
    let output = choose_output(graph, output, true)?;
    let color = graph.colors().at(output.source);
    let is_hdr = color.is_some_and(|color| matches!(color.colorimetry.transfer, Transfer::Pq | Transfer::Hlg));
    let mut words = args.video.iter().flat_map(|text| text.split_whitespace()).map(str::to_owned).peekable();
    let path = Path::new(&file);
    let preset = match words.next_if(|word| !word.starts_with('-')) {
        Some(name) => Preset::named(&name).ok_or_else(|| {
            let known = Preset::ALL.map(|preset| preset.name);
            Failure::user(format!("`--video {name}` is no codec here")).hint(format!("there are {}", known.join(", ")))
        })?,
        None => Preset::of_file(path, is_hdr).ok_or_else(|| {
            Failure::user(format!("no codec here writes `{file}`")).hint("films are written as .mov, .mp4 and .mkv")
        })?,
    };
    if !preset.suits(path) {
        let endings = preset.endings().join(", .");
        return Err(
            Failure::user(format!("{} is no codec of `{file}`", preset.name)).hint(format!("its files are .{endings}"))
        );
    }
    let mut saving = SaveOptions::plain(ImageFormat::Png);
    saving.encoding = Encoding { bits: 16, dither: None, alpha: Alpha::Drop, ..saving.encoding };
    let film = Some(FilmTarget { preset, more: words.collect() });
    Ok(Target { output: output.name.clone(), file, saving, film, gain_map: None })
}

fn no_light(output: &GraphOutput) -> Failure {
    let (name, state) = (&output.name, output.state.name());
    Failure::user(format!("output `{name}` is {state}, and `--output-space` converts light")).hint("leave it out")
}

/// The named output, or the first whose color state fits the file: encoded for PNG and JPEG, linear for EXR.
pub(crate) fn choose_output<'g>(
    graph: &'g Graph,
    wanted: Option<&str>,
    encoded: bool,
) -> Result<&'g GraphOutput, Failure> {
    let fits = |output: &&GraphOutput| (output.state == ColorState::Encoded) == encoded;
    let Some(name) = wanted else {
        return graph.outputs.iter().find(fits).ok_or_else(|| no_output(graph, encoded));
    };
    match graph.outputs.iter().find(|output| output.name == name) {
        None => {
            Err(Failure::user(format!("the pipeline has no output `{name}`")).hint(format!("it has {}", names(graph))))
        }
        Some(output) if fits(&output) => Ok(output),
        Some(output) => Err(wrong_file(output, encoded)),
    }
}

fn names(graph: &Graph) -> String {
    let names: Vec<String> = graph.outputs.iter().map(|o| format!("`{}` ({})", o.name, o.state.name())).collect();
    names.join(", ")
}

fn wrong_file(output: &GraphOutput, encoded: bool) -> Failure {
    let name = &output.name;
    match encoded {
        true => {
            Failure::user(format!("output `{name}` is {}, and this file holds encoded pictures", output.state.name()))
                .hint("write it to an `.exr` file, or add an `Encode` node")
        }
        false => Failure::user(format!("output `{name}` is Encoded, and an EXR holds linear light"))
            .hint("write it to a `.png` file"),
    }
}

fn no_output(graph: &Graph, encoded: bool) -> Failure {
    let (kind, hint) = match encoded {
        true => ("encoded", "write to an `.exr` file, or add an `Encode` node and an output for it"),
        false => ("linear", "write to a `.png` file, or add an output before the `Encode` node"),
    };
    Failure::user(format!("the pipeline has no {kind} output for this file; it has {}", names(graph))).hint(hint)
}

fn unknown_format(name: &str) -> Failure {
    if Path::new(name).is_dir() {
        return Failure::user(format!("`{name}` is a folder")).hint("name the file: `folder/out.png`");
    }
    let foreign = ForeignFormat::of_name(name).map(|format| format.what.to_owned());
    let read_only = || ImageFormat::of_name(name).map(|format| format!("a {} file", format.name()));
    if let Some(what) = foreign.or_else(read_only) {
        return Failure::user(format!("`{name}` would be {what}, which is not written")).hint(format!(
            "write `out.exr` for light or `out.png` with `--depth 16` for codes, and convert it: `oiiotool out.exr -o \
             {name}`"
        ));
    }
    let (encoded, linear) = (written_endings(true), written_endings(false));
    let quoted = |endings: &[String]| list(endings.iter().map(String::as_str), usize::MAX);
    Failure::user(format!("`{name}` ends in none of {}", quoted(&[&*encoded, &*linear].concat()))).hint(format!(
        "{} take an encoded output, {} a linear one",
        quoted(&encoded),
        quoted(&linear)
    ))
}

/// The usual endings of the files that are written, of those that hold encoded pictures or of the others.
fn written_endings(are_encoded: bool) -> Vec<String> {
    let formats = ImageFormat::ALL.into_iter().filter(|format| is_written(*format));
    formats
        .filter(|format| format.is_encoded() == are_encoded)
        .map(|format| format!(".{}", format.endings()[0]))
        .collect()
}

fn is_written(format: ImageFormat) -> bool {
    !format.depths().is_empty()
}

/// The format by the ending of a name; `None` if it is not written.
fn written_format(name: &str) -> Option<ImageFormat> {
    ImageFormat::of_name(name).filter(|format| is_written(*format))
}

/// The bits of a channel: those of `--depth` if the format has them. PQ and HLG need more than eight.
fn bits(format: ImageFormat, depth: Option<u8>, is_hdr: bool) -> u32 {
    let known = format.depths();
    let default = if is_hdr && known.contains(&16) { 16 } else { known[0] };
    depth.map(u32::from).filter(|bits| known.contains(bits)).unwrap_or(default)
}

/// Refuses a depth that no file can have.
fn check_depth(depth: u8, targets: &[Target]) -> Result<(), Failure> {
    let is_used = targets.iter().any(|target| target.film.is_none() && target.saving.encoding.bits == u32::from(depth));
    let Some(first) = targets.first().filter(|_| !is_used) else { return Ok(()) };
    if let Some(film) = &first.film {
        let FilmTarget { preset, .. } = film;
        return Err(Failure::user(format!("a film of {} has {} bits", preset.name, preset.bits))
            .hint("leave `--depth` out, or choose another codec: `--video ffv1`"));
    }
    let format = first.saving.encoding.format;
    let known: Vec<String> = format.depths().iter().map(u32::to_string).collect();
    let article = if format == ImageFormat::Exr { "an" } else { "a" };
    Err(Failure::user(format!("{article} {} has {} bits, not {depth}", format.name(), known.join(" or "))))
}
