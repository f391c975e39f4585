//! Arguments of `meter`.

use std::path::PathBuf;

use clap::Args;

use super::files::ReadArgs;
use super::headings::{INPUT_FILES, OUTPUT_FILES, SEQUENCES};
use super::options::{DeviceOptions, ImageOptions, PipelineOptions, PlanOptions, parse_fps, parse_size};

#[derive(Debug, Args)]
pub(crate) struct MeterArgs {
    /// The pipeline file, or the name of a built-in pipeline
    pub(crate) pipeline: PathBuf,
    /// The sequence for the pipeline's first input, as for `render`
    pub(crate) input: Option<String>,
    /// The file for all frames, which can be joined with others line by line; or files: `shot.####.meter`
    #[arg(help_heading = OUTPUT_FILES, short, long, value_name = "FILE")]
    pub(crate) out: String,
    /// The image for another input, as for `render`
    #[arg(help_heading = INPUT_FILES, long = "input", value_name = "NAME=FILE")]
    pub(crate) inputs: Vec<String>,
    /// Slices of the images of volumes
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=2048))]
    #[arg(help_heading = INPUT_FILES)]
    pub(crate) slices: Option<u32>,
    /// Frames to measure: `1-96`, `1-96x2` or `1-96:2`, `7,12-20`
    #[arg(help_heading = SEQUENCES, long, value_name = "RANGE")]
    pub(crate) frames: Option<String>,
    /// Frames that begin a new shot, as for `render`
    #[arg(help_heading = SEQUENCES, long, value_name = "FRAMES")]
    pub(crate) cut: Option<String>,
    /// Frames per second
    #[arg(help_heading = SEQUENCES, long, default_value_t = 24.0, value_parser = parse_fps)]
    pub(crate) fps: f32,
    /// Print progress and status of each frame, as for `render`
    #[arg(long)]
    pub(crate) openjd: bool,
    /// Pixels of a frame, for a pipeline without an input image
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
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
