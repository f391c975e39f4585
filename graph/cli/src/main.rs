//! The program with the built-in node kinds.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage_cli::main(&[afterimage_nodes::ALL])
}
