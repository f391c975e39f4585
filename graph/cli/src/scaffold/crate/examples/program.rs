//! The program with the built-in kinds and those of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage_cli::main(&[afterimage_nodes::ALL, my_kind::ALL])
}
