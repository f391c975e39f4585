//! Headings of options in the help that several structs share. A struct with a heading is flattened after all options
//! without one, because clap gives its heading to the options that follow.

pub(super) const INPUT_FILES: &str = "Input files";
pub(super) const OUTPUT_FILES: &str = "Output files";
pub(super) const SEQUENCES: &str = "Sequences";
pub(super) const PIPELINE: &str = "Pipeline";
pub(crate) const MACHINE: &str = "Machine";
