//! The plug-in author's own program: the built-in nodes and hers.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage::main(&[afterimage_nodes::ALL, halftone::ALL])
}
