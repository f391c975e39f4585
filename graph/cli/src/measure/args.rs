//! The arguments of `measure` and `tune`.

use std::path::PathBuf;

use clap::Args;

use crate::args::{DeviceOptions, PipelineOptions, parse_size};

/// What each figure means, below the options.
const FIGURES: &str = "\
The truth is the same pipeline with every intermediate in 32 bits and every quality switch at its most exact.
Each figure is the worst over the images; JSON and CSV have those of each image too. Errors are those of an encoded output
before it is dithered and rounded to codes.

  time      the median frame, on the GPU at its full clocks; `host` where timestamps cannot be trusted, as on a processor
  memory    the most bytes that images between hold at once; moved: what all passes read and write in a frame
  max       the largest error of a channel, in 8-bit codes (PU21 codes for HDR outputs, 256 of them up to 100 cd/m2)
  p99.9     the error that one pixel in a thousand exceeds, in codes
  PSNR      decibels; SSIM: likeness of structure, 1 is equal; FLIP: what a viewer sees when alternating, 0 to 1
  dE2000    mean colour difference (dE ITP for HDR outputs); 1 is just noticeable
  flicker   99.9 percentile, in codes, of what changes between two frames and does not in the truth";

/// The pictures and the pipeline that are measured.
#[derive(Debug, Args)]
pub(crate) struct Material {
    /// Images for the pipeline's first input; `shot.####.exr` is a sequence; the built-in scene if there are none
    #[arg(value_name = "IN")]
    pub(crate) images: Vec<String>,
    /// The image for another input: `--input albedo=albedo.exr`
    #[arg(long = "input", value_name = "NAME=FILE")]
    pub(crate) inputs: Vec<String>,
    /// Also walk through the built-in scene
    #[arg(long)]
    pub(crate) scene: bool,
    /// Pixels of the built-in scene
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Frames of the walk through the built-in scene, and of a still image in a pipeline that remembers
    #[arg(long, value_name = "FRAMES", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) walk: u32,
    /// Frames of a sequence: `1-96`, `1-96x2`, `7,12-20`
    #[arg(long, value_name = "RANGE")]
    pub(crate) frames: Option<String>,
    /// Frames in a second, for what adapts over time
    #[arg(long, default_value_t = 24.0)]
    pub(crate) fps: f32,
    /// Which output to judge; otherwise the first encoded one, or the first
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Option<String>,
    /// How often the frame is timed; 50 times on a GPU and 7 on a processor by default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) repeats: Option<u32>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

#[derive(Debug, Args)]
#[command(after_help = FIGURES)]
pub(crate) struct MeasureArgs {
    /// The pipeline file, or with `--docs` a folder of them
    pub(crate) pipeline: PathBuf,
    #[command(flatten)]
    pub(crate) material: Material,
    /// Only the tiers, not each switch on its own
    #[arg(long)]
    pub(crate) tiers: bool,
    /// Write a manual's page: this adapter's figures, plots, and a `README.md` that has the figures of every adapter in the folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["json", "csv", "plot", "error_image"])]
    pub(crate) docs: Option<PathBuf>,
    /// Write all figures as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write all figures as comma-separated values
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Draw time against error, as `.svg` or `.png`; may be given twice
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Vec<PathBuf>,
    /// Draw where the error of each variant is: black below 1/16 of a code, red near 1, white from 64
    #[arg(long, value_name = "DIR")]
    pub(crate) error_image: Option<PathBuf>,
}

/// What a tuned pipeline must keep.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct GoalArgs {
    /// The most time of a frame, such as `0.8ms` or `800us`: the most accurate pipeline within it is searched
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub(crate) budget: Option<f64>,
    /// The most error (99.9 percentile, in 8-bit codes): the fastest pipeline within it is searched
    #[arg(long, value_name = "CODES", value_parser = parse_error)]
    pub(crate) error: Option<f64>,
}

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    /// The pipeline file
    pub(crate) pipeline: PathBuf,
    #[command(flatten)]
    pub(crate) material: Material,
    #[command(flatten)]
    pub(crate) goal: GoalArgs,
    /// The name of the tier
    #[arg(long, default_value = "tuned")]
    pub(crate) name: String,
    /// Where the pipeline with the new tier goes; standard output otherwise
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// What was measured so far; a later run goes on from there
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
}

/// Milliseconds of `0.8ms`, `800us` or `0.8`.
fn parse_time(text: &str) -> Result<f64, String> {
    let (number, unit) = match (text.strip_suffix("us").or(text.strip_suffix("µs")), text.strip_suffix("ms")) {
        (Some(number), _) => (number, 1e-3),
        (None, Some(number)) => (number, 1.0),
        (None, None) => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(time) if time.is_finite() && time > 0.0 => Ok(time * unit),
        _ => Err("a time is a number above 0 with `ms` or `us`, such as 0.8ms".into()),
    }
}

fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error.is_finite() && error >= 0.0 => Ok(error),
        _ => Err("an error is a number from 0, such as 0.5".into()),
    }
}
