//! The program with the built-in kinds and those of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage::main(&[afterimage_nodes::ALL, my_kind::ALL])
}
