//! Headings of options in the help that several structs share.

pub(super) const INPUT_FILES: &str = "Input files";
pub(super) const OUTPUT_FILES: &str = "Output files";
pub(super) const SEQUENCES: &str = "Sequences";
