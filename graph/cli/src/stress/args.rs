//! The arguments of `stress`.

use std::path::PathBuf;

use clap::Args;

use crate::args::{DeviceOptions, PipelineOptions, parse_size};

/// What is checked, below the options.
const VERDICTS: &str = "\
Every image must come out finite, in the range of its state, and as if the guard's work on NaN, infinities and negatives had been done
before; a constant must stay constant, a symmetric image symmetric, a ramp rising, and light must be kept, by the kinds that promise it.
A node that is left out as an identity must be one. The picture must be the same dispatched and drawn, fused and not, in tiles and not,
side by side in one dispatch and not, by subgroups and not.
What remembers must hold still in steps of no time, arrive in long ones, forget at a cut, and recover from a frame of NaN.";

#[derive(Debug, Args)]
#[command(after_help = VERDICTS)]
pub(crate) struct StressArgs {
    /// The pipeline files; without them and without kinds, all shipped pipelines and all kinds
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
    /// Only with light that may be negative
    #[arg(long)]
    pub(crate) signed: bool,
    /// Only this image or sequence
    #[arg(long, value_name = "NAME")]
    pub(crate) case: Option<String>,
    /// Only this size
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Leave parameters at their defaults, or where `--set` puts them
    #[arg(long)]
    pub(crate) defaults: bool,
    /// A part of the cases that takes seconds
    #[arg(long)]
    pub(crate) quick: bool,
    /// Leave out the guard of the images: shows what it guards from, and fails
    #[arg(long)]
    pub(crate) unguarded: bool,
    /// List every failed case
    #[arg(long)]
    pub(crate) all: bool,
    /// Write the tables as Markdown
    #[arg(long, value_name = "FILE", conflicts_with = "conditioning")]
    pub(crate) markdown: Option<PathBuf>,
    /// Measure instead how much an input error grows in each kind
    #[arg(long)]
    pub(crate) conditioning: bool,
    /// Write the figures of `--conditioning` as JSON
    #[arg(long, value_name = "FILE", requires = "conditioning")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}
