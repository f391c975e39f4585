//! The program with the built-in node kinds.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage::main(&[afterimage_nodes::ALL])
}
