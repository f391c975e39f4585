//! The program with the built-in kinds: what tests of the command line start.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage_cli::main(&[afterimage_nodes::ALL])
}
