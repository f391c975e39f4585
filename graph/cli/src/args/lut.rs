//! Options of `lut`.

use std::path::PathBuf;

use afterimage_color::process::LutSpace;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::headings::OUTPUT_FILES;
use super::options::{DeviceOptions, PipelineOptions};

#[derive(Debug, Args)]
pub(crate) struct LutArgs {
    /// The pipeline file, or the name of a built-in pipeline
    pub(crate) pipeline: PathBuf,
    /// The table: a `.cube` or a `.clf` file
    #[arg(help_heading = OUTPUT_FILES, short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// The space of the colors that the other program gives to the table
    #[arg(long, value_name = "SPACE", ignore_case = true, value_parser = spaces())]
    pub(crate) from: LutSpace,
    /// Entries of each side of the table: 33 or 65 for most programs
    #[arg(long, value_name = "ENTRIES", default_value_t = 33, value_parser = clap::value_parser!(u32).range(2..=129))]
    pub(crate) size: u32,
    /// For linear colors: put a camera's logarithm up to so many stops above 1 before the table, as a 1-D table in a
    /// `.cube` file
    #[arg(long, value_name = "STOPS", num_args = 0..=1, require_equals = true, default_missing_value = "6")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(crate) shaper: Option<u32>,
    /// The output whose colors the table returns; by default the first encoded one
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Option<String>,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

fn spaces() -> impl TypedValueParser<Value = LutSpace> {
    let all = || LutSpace::ALL.iter().copied().filter(|space| *space != LutSpace::Same);
    PossibleValuesParser::new(all().map(LutSpace::name))
        .map(move |name| all().find(|space| space.name().eq_ignore_ascii_case(&name)).expect("it is one of the names"))
}
