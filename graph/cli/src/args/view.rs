//! Arguments of `view`.

use std::path::PathBuf;

use clap::Args;

use super::headings::{MACHINE, PIPELINE, SEQUENCES};
use super::options::{ImageOptions, KindOptions, parse_fps, parse_size};

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// The pipeline file, or the name of a built-in pipeline; by default `tsushima`
    pub(crate) pipeline: Option<PathBuf>,
    /// The image for the pipeline's first input, as for `render`; by default the built-in scene, which moves
    pub(crate) input: Option<String>,
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
