//! The program with the built-in kinds and those of this crate: `cargo run -p halftone --example program -- nodes
//! Halftone` describes the kind.

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage_cli::main(&[afterimage_nodes::ALL, halftone::ALL])
}
