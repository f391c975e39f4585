//! The arguments of `stress`.

use std::path::PathBuf;

use clap::Args;

use super::headings::OUTPUT_FILES;
use super::options::{DeviceOptions, PipelineOptions, parse_size};

/// The variable that stands for `--target`.
pub(crate) const TARGET: &str = "AFTERIMAGE_STRESS_TARGET";

/// The tests, below the options. The terminal's width wraps the lines.
const VERDICTS: &str = "\
Every output must be finite, in the range of its color state, and the same as with images whose NaN, infinities and \
negatives are replaced before. A constant must stay constant, a symmetric image symmetric, a ramp rising, and light \
must be kept, by the kinds that promise it. A node that is skipped as an identity must be one. The output must be \
the same dispatched and drawn, fused and not. Histories must not \
change in steps of no time, must settle in long steps, start again at a reset, and recover from a frame of NaN. Frames \
after days and months must move as the first ones do.";

#[derive(Debug, Args)]
#[command(after_help = VERDICTS)]
pub(crate) struct StressArgs {
    /// The pipelines, by their files or names; without these and kinds, all built-in pipelines and all kinds
    #[arg(value_name = "PIPELINE")]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Every node kind on its own
    #[arg(long)]
    pub(crate) kinds: bool,
    /// This node kind on its own
    #[arg(long = "kind", value_name = "KIND")]
    pub(crate) kind: Vec<String>,
    /// Only without images for optional inputs
    #[arg(long)]
    pub(crate) bare: bool,
    /// Only this image or sequence
    #[arg(long, value_name = "NAME")]
    pub(crate) case: Option<String>,
    /// Only this size
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Keep parameters at their defaults, or at the values of `--set`
    #[arg(long)]
    pub(crate) defaults: bool,
    /// Run a part of the cases, which takes seconds
    #[arg(long)]
    pub(crate) quick: bool,
    /// Do not sanitize the images: shows what sanitizing prevents, and fails
    #[arg(long)]
    pub(crate) unsanitized: bool,
    /// Processes that run at once, each with one pipeline or kind; by default one for each core
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// Run the pipeline or kind at this place of the list, and print its results as JSON: a process of `--jobs`
    #[arg(long, hide = true, value_name = "INDEX", env = TARGET)]
    pub(crate) target: Option<usize>,
    /// List every failed case
    #[arg(long)]
    pub(crate) all: bool,
    /// Write the results as JSON
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}
