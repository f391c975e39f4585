//! The command line.

pub(crate) mod files;
mod headings;
pub(crate) mod lut;
pub(crate) mod measure;
pub(crate) mod meter;
mod options;
pub(crate) mod stress;
#[cfg(feature = "view")]
pub(crate) mod view;

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::builder::Resettable;
use clap::{Args, CommandFactory as _, Parser, Subcommand, ValueEnum};

use crate::built_in::put_in_order;
use files::{ExrArgs, ReadArgs};
use headings::{INPUT_FILES, OUTPUT_FILES, SEQUENCES};
use lut::LutArgs;
use measure::{MeasureArgs, TuneArgs};
use meter::MeterArgs;
use stress::StressArgs;
#[cfg(feature = "view")]
use view::ViewArgs;

pub(crate) use headings::MACHINE;
pub(crate) use options::{
    Crop, DeviceOptions, ImageOptions, KindOptions, PipelineOptions, PlanOptions, parse_crop, parse_fps, parse_size,
};

/// The text of `--version`; `-V` prints its first line. A test compares it with the versions that are built.
const LONG_VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\nwgpu 30.0.1, naga 30.0.1");

/// Post-processing for HDR images: a pipeline is a RON file, its nodes are plug-ins.
#[derive(Debug, Parser)]
#[command(name = "afterimage", version, long_version = LONG_VERSION, about, max_term_width = 100)]
pub(crate) struct Arguments {
    /// Work in this folder: names of files are relative to it
    #[arg(short = 'C', value_name = "FOLDER")]
    pub(crate) folder: Option<PathBuf>,
    /// The OpenColorIO config of `OcioTransform` nodes and of `--input-space`: a `.ocio` or `.ocioz` file, or a
    /// built-in one such as `ocio://default`. By default the one that the variable `OCIO` names
    #[cfg(feature = "ocio")]
    #[arg(long, value_name = "CONFIG", global = true)]
    pub(crate) ocio: Option<String>,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render the built-in scene through every built-in pipeline
    Demo(DemoArgs),
    /// Look at a pipeline in a window, and adjust its parameters
    #[cfg(feature = "view")]
    View(ViewArgs),
    /// Render an image or a sequence through a pipeline
    Render(RenderArgs),
    /// Measure the frames of a sequence in any order, for `render --meter`, which renders any range of them as in the
    /// whole sequence
    Meter(MeterArgs),
    /// Print a render as a template of Open Job Description (2023-09), for a render farm
    Job(JobArgs),
    /// Say what images and films hold, from their headers: parts, channels, sizes, colors and what states them
    Info(InfoArgs),
    /// Check pipeline files: all errors at once, with locations
    Check(CheckArgs),
    /// Explain the code of an error or a warning, with an example
    Explain(ExplainArgs),
    /// Show what a pipeline does on the GPU: passes, order, barriers, memory
    Plan(PlanArgs),
    /// Write what a pipeline does to colors as a look-up table for other programs, with its error
    Lut(LutArgs),
    /// Write a new pipeline from a template, to begin with
    New(NewArgs),
    /// Describe the node kinds
    Nodes(NodesArgs),
    /// List the built-in pipelines, show one, or write it to a file
    Pipelines(PipelinesArgs),
    /// Time against error, for every tier and every quality switch of a pipeline
    Measure(MeasureArgs),
    /// Search the quality switches for the best pipeline within a time or an error
    Tune(TuneArgs),
    /// Measure a pipeline on this machine's graphics adapter
    Bench(BenchArgs),
    /// Test every pipeline and every node kind with extreme images, parameters and sizes
    Stress(StressArgs),
    /// Print a script that completes the words of this program in a shell
    Completions(CompletionsArgs),
    /// Write a manual page for each command
    Man(ManArgs),
}

#[derive(Debug, Args)]
pub(crate) struct PipelinesArgs {
    /// The pipeline to show; all are listed without it
    pub(crate) name: Option<String>,
    /// Write it to this file, and what it uses next to it, to change it
    #[arg(long, value_name = "FILE", requires = "name")]
    pub(crate) write: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Images (EXR, HDR, PNG, JPEG, TIFF, DPX) or films; `shot.####.exr` is a sequence, `file.exr#layer` a layer
    #[arg(required = true)]
    pub(crate) files: Vec<String>,
    /// Read the pixels, too, and print the range of each channel and how many numbers are NaN or infinite
    #[arg(long)]
    pub(crate) pixels: bool,
    /// Print a list as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) images: ImageOptions,
}

#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    /// The code, such as `state-conflict` of `error[state-conflict]`; all are listed without it
    pub(crate) code: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell: `afterimage completions bash > ~/.local/share/bash-completion/completions/afterimage`
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// The folder for the pages: `afterimage man ~/.local/share/man/man1`
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// The folder for the images
    #[arg(help_heading = OUTPUT_FILES, short, long, value_name = "FOLDER", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Pixels of the scene
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// The time of the scene in seconds
    #[arg(long, default_value_t = 0.0)]
    pub(crate) time: f32,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// The pipeline file, or the name of a built-in pipeline
    pub(crate) pipeline: PathBuf,
    /// The image for the pipeline's first input: EXR, HDR, PNG, JPEG, TIFF or DPX; `shot.####.exr` is a sequence,
    /// `file.exr#layer` a layer, `-` standard input, and `.mov`, `.mp4` or `.mkv` a film, whose frames count from 1. It
    /// may stand before the pipeline
    pub(crate) input: Option<String>,
    /// The output file: `.png`, `.tif` or `.jpg` for an encoded output, `.exr` for a linear one; `out.####.png` for a
    /// sequence; `.mov`, `.mp4` or `.mkv` for a film; `-` for standard output, as PNG or EXR
    #[arg(help_heading = OUTPUT_FILES, short, long, value_name = "FILE")]
    pub(crate) out: Option<String>,
    /// The image for another input: `--input albedo=albedo.exr`; a camera is a JSON file with its matrices, or an
    /// EXR file that states them: `--input camera=camera.####.json`
    #[arg(help_heading = INPUT_FILES, long = "input", value_name = "NAME=FILE")]
    pub(crate) inputs: Vec<String>,
    /// Slices of the images of volumes, which lie one below the other, the nearest first: `--input fog=fog.exr
    /// --slices 64`
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=2048))]
    #[arg(help_heading = INPUT_FILES)]
    pub(crate) slices: Option<u32>,
    /// The output to write to the file of `-o`; by default the first that fits the file's extension. With a file, an
    /// output that is written to that file: `--output sdr=sdr.png --output hdr=hdr.png`
    #[arg(help_heading = OUTPUT_FILES, long = "output", value_name = "NAME[=FILE]")]
    pub(crate) outputs: Vec<String>,
    /// Frames of a sequence: `1-96`, `1-96x2` or `1-96:2`, `7,12-20`; required for a sequence from a pipeline without
    /// inputs
    #[arg(help_heading = SEQUENCES, long, value_name = "RANGE")]
    pub(crate) frames: Option<String>,
    /// Frames that begin a new shot: adaptation and histories start again; written as for `--frames`
    #[arg(help_heading = SEQUENCES, long, value_name = "FRAMES")]
    pub(crate) cut: Option<String>,
    /// Begin with the exposure that follows from what `afterimage meter` has measured in the frames before, so that any
    /// range has the pixels of the whole sequence: a file, or numbered files: `--meter shot.####.meter`
    #[arg(help_heading = SEQUENCES, long, value_name = "FILE")]
    pub(crate) meter: Option<String>,
    /// Render so many frames of the sequence before the range without writing them, for a state that is almost that of
    /// the whole sequence
    #[arg(help_heading = SEQUENCES, long, value_name = "COUNT", default_value_t = 0)]
    pub(crate) preroll: u32,
    /// Go on after a frame that cannot be read or written; the exit status is 1 at the end
    #[arg(help_heading = SEQUENCES, long)]
    pub(crate) keep_going: bool,
    /// Leave frames out whose files are there and whole
    #[arg(help_heading = SEQUENCES, long)]
    pub(crate) skip_existing: bool,
    /// Also write a report as JSON, even if the run fails: exposure, repaired pixels, seconds and outcome of each
    /// frame, the hash of the plan, adapter, driver, version
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Frames per second, for adaptation over time
    #[arg(help_heading = SEQUENCES, long, default_value_t = 24.0, value_parser = parse_fps)]
    pub(crate) fps: f32,
    /// Pixels to render, for a pipeline without an input image
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Write these columns and rows of the picture only, from the corner `X,Y`: their pixels are those of the whole
    /// picture, before the noise of 8 bits. Meters see all of it
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "X,Y,WxH", value_parser = parse_crop)]
    pub(crate) crop: Option<Crop>,
    /// Bits of a channel: 8 or 16 in PNG, 16 or 32 in EXR, 8 in JPEG, 8, 16 or 32 in TIFF, of which 32 are floats of a
    /// linear output; by default the first of them, and 16 in a PNG of PQ or HLG. It replaces the depth of the
    /// pipeline's `Dither`. Files of a format without that depth have their own
    #[arg(help_heading = OUTPUT_FILES, long)]
    pub(crate) depth: Option<u8>,
    /// Round to 8 bits without dither, also where the pipeline has a `Dither`. 16 bits are always rounded
    #[arg(help_heading = OUTPUT_FILES, long)]
    pub(crate) no_dither: bool,
    /// Render what a host sees in the frame of this number: the `Dither` of the pipeline makes the codes, and the
    /// parameters of `--set` are dynamic. For frames that `Post::capture` has written
    #[arg(long, value_name = "NUMBER", hide = true, conflicts_with_all = ["no_dither", "frames"])]
    pub(crate) captured: Option<u32>,
    /// Whether a PNG has alpha
    #[arg(help_heading = OUTPUT_FILES, long, value_enum, default_value_t = AlphaChoice::Auto)]
    pub(crate) alpha: AlphaChoice,
    /// The HDR output that a JPEG also has, as a gain map (ISO 21496-1, Ultra HDR) for displays that show it:
    /// `-o photo.jpg --gain-map hdr`
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "NAME", conflicts_with = "crop")]
    pub(crate) gain_map: Option<String>,
    /// Quality of a JPEG, 1 to 100; 92 by default
    #[arg(help_heading = OUTPUT_FILES, long, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: Option<u8>,
    /// The codec of a film, and further options of `ffmpeg`, which writes it: prores, prores4444, h264, hevc (of 10
    /// bits) or ffv1 (of 16, without loss), such as `--video "hevc -crf 18"`. By default that of the ending
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "CODEC")]
    pub(crate) video: Option<String>,
    /// Print the time of each stage and of each pass
    #[arg(long)]
    pub(crate) timings: bool,
    /// Print progress and status of each frame on standard output as tasks of Open Job Description do:
    /// `openjd_progress: 12.5`. The tasks of `afterimage job` have it
    #[arg(long)]
    pub(crate) openjd: bool,
    /// Render again whenever the pipeline, a file that it names, a shader of `--nodes` or an image changes
    #[arg(long)]
    pub(crate) watch: bool,
    #[command(flatten)]
    pub(crate) exr: ExrArgs,
    #[command(flatten)]
    pub(crate) reading: ReadArgs,
    #[command(flatten)]
    pub(crate) images: ImageOptions,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) plan: PlanOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

/// Help about render managers without Open Job Description.
const ENGINES: &str = "\
Engines that do not read templates run `render` itself, a command for each chunk of frames. With the words
  RENDER = render tsushima shot.####.exr -o out.####.png --meter shot.####.meter
  GNU parallel   parallel -j 4 afterimage RENDER --frames {} ::: 1-20 21-40
  Deadline 10    deadlinecommand -SubmitCommandLineJob -name shot -frames 1-96 -chunksize 20 -executable afterimage
                 -arguments \"RENDER --frames <STARTFRAME>-<ENDFRAME>\"
  OpenCue        a shell layer of range 1-96, chunk 20: afterimage RENDER --frames #FRAME_START#-#FRAME_END#
  Flamenco 3     in a job type, for each chunk of frameChunker(settings.frames, settings.chunk_size):
                 author.Command(\"exec\", {exe: \"afterimage\", args: [...RENDER, \"--frames\", chunk]})
before it, in the same way, `meter tsushima shot.####.exr -o shot.####.meter --frames ...` for a metered exposure.";

#[derive(Debug, Args)]
#[command(after_help = ENGINES)]
pub(crate) struct JobArgs {
    /// Frames of a chunk; chunks run side by side. Where frames depend on those before, and not by a meter alone, a
    /// chunk is a whole shot, which `--cut` separates, unless there is a `--preroll`
    #[arg(help_heading = SEQUENCES, long, value_name = "COUNT", default_value_t = 20,
          value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) chunk: u32,
    #[command(flatten)]
    pub(crate) render: RenderArgs,
}

impl RenderArgs {
    /// Exchanges the pipeline and the image if they stand the other way round.
    pub(crate) fn put_in_order(&mut self) {
        put_in_order(&mut self.pipeline, &mut self.input);
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum AlphaChoice {
    /// Where the output declares `alpha: Coverage`, and it is not 1 in all pixels
    Auto,
    /// Always
    Keep,
    /// Never
    Drop,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct CheckArgs {
    /// The pipeline files, or names of built-in pipelines
    #[arg(required = true)]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Print the diagnostics as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the right words into the files where the check knows them: misspelt names, quotes too many or too few.
    /// Each change is printed
    #[arg(long)]
    pub(crate) fix: bool,
    /// Fail with status 1 for warnings, too
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) deny: Option<Deny>,
    /// Also plan each pipeline and verify the plan
    #[arg(long)]
    pub(crate) plan: bool,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Deny {
    /// All warnings
    Warnings,
}

#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    /// The pipeline file, or the name of a built-in pipeline
    pub(crate) pipeline: PathBuf,
    /// Pixels of the inputs
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// How to print it
    #[arg(long, value_enum, default_value_t = PlanFormat::Text)]
    pub(crate) format: PlanFormat,
    /// Print the differences from the plan of another file; as text or JSON
    #[arg(long, value_name = "OTHER")]
    pub(crate) diff: Option<PathBuf>,
    /// Print the differences from the plan of another tier of this file; as text or JSON
    #[arg(long, value_name = "TIER", conflicts_with = "diff")]
    pub(crate) diff_tier: Option<String>,
    /// Plan for this machine's graphics adapter instead of a typical one
    #[arg(long)]
    pub(crate) device: bool,
    /// Print how far each table of colors is from its nodes; opens a graphics adapter
    #[arg(long, conflicts_with_all = ["format", "diff", "diff_tier"])]
    pub(crate) bake_error: bool,
    /// Plan as for a host that changes this parameter in every frame: `--dynamic lit.strength`
    #[arg(long, value_name = "NODE.PARAMETER")]
    pub(crate) dynamic: Vec<String>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) plan: PlanOptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanFormat {
    /// A table
    Text,
    /// Canonical JSON
    Json,
    /// A timeline
    Svg,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// The file, such as `look.ron`; one that exists is not replaced
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct NodesArgs {
    /// The kind to describe, or words of a topic, such as `film grain`; all are listed without it
    pub(crate) kind: Vec<String>,
    /// Write the files of a new kind of this name, which runs at once, to a new folder: `--new SoftGlow`
    #[arg(long, value_name = "NAME", conflicts_with = "kind")]
    pub(crate) new: Option<String>,
    /// With `--new`: write a crate with the kind in Rust, and a program that has it
    #[arg(long, requires = "new")]
    pub(crate) rust: bool,
    /// With `--rust`: the repository of Afterimage, on which the crate depends; by default one that this folder or the
    /// program is in, and without one packages of the program's version
    #[arg(long, value_name = "DIR", requires = "rust")]
    pub(crate) repository: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) kinds: KindOptions,
}

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// The pipeline file, or the name of a built-in pipeline
    pub(crate) pipeline: PathBuf,
    /// Pixels of a frame
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Samples of each median
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// Measure as if the host promised that its images hold finite numbers only: the plan does not repair them
    #[arg(long)]
    pub(crate) finite: bool,
    /// Also write the figures as JSON
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) plan: PlanOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

/// The definition of the command line. A variable that is empty stands for no option.
pub(crate) fn command() -> clap::Command {
    let is_empty = |name: &OsStr| std::env::var_os(name).is_some_and(|value| value.is_empty());
    Arguments::command().mut_subcommands(|command| {
        command.mut_args(|arg| if arg.get_env().is_some_and(is_empty) { arg.env(Resettable::Reset) } else { arg })
    })
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::headings::PIPELINE;
    use super::*;

    /// The options of a struct that is flattened into commands.
    fn options_of<T: Args>() -> BTreeSet<String> {
        let command = T::augment_args(clap::Command::new("any"));
        command.get_arguments().filter_map(|arg| Some(arg.get_long()?.to_owned())).collect()
    }

    #[test]
    fn an_option_stands_under_its_own_heading() {
        let of_pipelines = &options_of::<PipelineOptions>() | &options_of::<KindOptions>();
        let of_machines = &options_of::<DeviceOptions>() | &options_of::<ImageOptions>();
        let closed = [(PIPELINE, of_pipelines), (MACHINE, of_machines)];
        let mut headings: BTreeMap<(String, Option<String>), (Option<String>, String)> = BTreeMap::new();
        for command in command().get_subcommands() {
            for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
                let Some(option) = arg.get_long() else { continue };
                let heading = arg.get_help_heading().map(str::to_owned);
                for (name, own) in &closed {
                    let is_under = heading.as_deref() == Some(*name);
                    assert!(!is_under || own.contains(option), "--{option} of {} under {name}", command.get_name());
                }
                // Options of one name may be others: `--window`.
                let value = arg.get_value_names().and_then(|names| Some(names.first()?.to_string()));
                let here = (heading, command.get_name().to_owned());
                let known = headings.entry((option.to_owned(), value)).or_insert_with(|| here.clone());
                assert_eq!(known.0, here.0, "--{option} of {} and of {}", known.1, here.1);
            }
        }
    }
}
