//! The program `afterimage`, as a library: a plug-in author's own program is three lines around [`main()`].

mod args;
mod bench;
mod cache;
mod check;
mod demo;
mod failure;
mod measure;
mod memory;
mod nodes;
mod pipeline;
mod plan;
mod render;
mod save;
mod session;
mod shipped;
pub mod stress;
mod terminal;
mod watch;

use std::process::ExitCode;

use afterimage_graph::node::NodeKind;
use clap::Parser as _;

use args::{Arguments, Command};

/// Runs the program with the kinds of these tables and the arguments of the process.
pub fn main(tables: &[&[NodeKind]]) -> ExitCode {
    run(tables, std::env::args_os())
}

/// Runs the program with the kinds of these tables and these arguments, the first of which is the program's name.
pub fn run(tables: &[&[NodeKind]], arguments: impl IntoIterator<Item = std::ffi::OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            let asked_for_help = !error.use_stderr();
            let _ = error.print();
            return ExitCode::from(u8::from(!asked_for_help));
        }
    };
    let done = match &arguments.command {
        Command::Demo(args) => demo::run(args, tables),
        Command::Render(args) => render::run(args, tables),
        Command::Check(args) => check::run(args, tables),
        Command::Plan(args) => plan::run(args, tables),
        Command::Nodes(args) => nodes::run(args, tables),
        Command::Measure(args) => measure::run(args, tables),
        Command::Tune(args) => measure::tune::run(args, tables),
        Command::Bench(args) => bench::run(args, tables),
        Command::Stress(args) => stress::run(args, tables),
    };
    match done.and_then(|()| terminal::all_was_said()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
