//! Arguments of `view`.

use std::path::PathBuf;

use clap::Args;

use super::files::{InputSpace, parse_input_space};
use super::headings::{INPUT_FILES, MACHINE, PIPELINE, SEQUENCES};
use super::options::{ImageOptions, KindOptions, parse_fps, parse_size};

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// The pipeline file, or the name of a built-in pipeline; by default `tsushima`
    pub(crate) pipeline: Option<PathBuf>,
    /// The image for the pipeline's first input, as for `render`; by default the built-in scene, which moves. It may
    /// stand before the pipeline, or alone
    pub(crate) input: Option<String>,
    /// The image for another input, or a camera, as for `render`: `--input depth=depth.exr --input camera=camera.json`
    #[arg(help_heading = INPUT_FILES, long = "input", value_name = "NAME=FILE")]
    pub(crate) inputs: Vec<String>,
    /// What the numbers of the images mean, whatever the files state, as for `render`: `ACEScg`, or for one input
    /// `albedo=Rec709`
    #[arg(help_heading = INPUT_FILES, long, value_name = "[INPUT=]SPACE", value_parser = parse_input_space)]
    pub(crate) input_space: Vec<InputSpace>,
    /// Slices of the images of volumes, which lie one below the other, the nearest first
    #[arg(help_heading = INPUT_FILES, long, value_name = "COUNT")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=2048))]
    pub(crate) slices: Option<u32>,
    /// The tier to begin with
    #[arg(help_heading = PIPELINE, long)]
    pub(crate) tier: Option<String>,
    /// Set a fact about the scene: `--fact emissive=false`
    #[arg(help_heading = PIPELINE, long = "fact", value_name = "NAME=VALUE")]
    pub(crate) facts: Vec<String>,
    /// Pixels of the built-in scene
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// The size of the window
    #[arg(long, value_name = "WxH", default_value = "1440x900", value_parser = parse_size)]
    pub(crate) window: (u32, u32),
    /// Frames per second of a sequence
    #[arg(help_heading = SEQUENCES, long, default_value_t = 24.0, value_parser = parse_fps)]
    pub(crate) fps: f32,
    /// Part of the name of the graphics adapter; by default the fastest
    #[arg(help_heading = MACHINE, long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    #[command(flatten)]
    pub(crate) images: ImageOptions,
    #[command(flatten)]
    pub(crate) kinds: KindOptions,
}
