//! The program `afterimage` as a library: the program of a plug-in author calls [`main()`] with one more table of
//! kinds.
// rustdoc asks whether types that hold a GPU are `Sync`, which goes through more than 128 types of wgpu.
#![recursion_limit = "256"]

mod args;
mod bench;
mod cameras;
mod check;
mod demo;
mod device;
mod failure;
mod files;
mod measure;
mod nodes;
mod pipeline;
mod plan;
mod progress;
mod quantize;
mod render;
mod run_files;
mod save;
mod scaffold;
mod stress;
mod terminal;
mod tier_file;
mod tune;
#[cfg(feature = "view")]
mod view;
mod watch;

use std::process::ExitCode;

use afterimage_graph::node::NodeKind;
use clap::Parser as _;

use args::{Arguments, Command};

/// Runs the program with the kinds of these tables and the arguments of the process.
pub fn main(tables: &[&[NodeKind]]) -> ExitCode {
    run(tables, std::env::args_os())
}

/// The kinds whose passes a host fills, without those whose names the tables have.
fn host_kinds(tables: &[&[NodeKind]]) -> Vec<NodeKind> {
    let is_new = |kind: &&NodeKind| tables.iter().copied().flatten().all(|known| known.name() != kind.name());
    afterimage_nodes::HOST.iter().filter(is_new).cloned().collect()
}

/// Runs the program with the kinds of these tables and these arguments, the first of which is the program's name.
pub fn run(tables: &[&[NodeKind]], arguments: impl IntoIterator<Item = std::ffi::OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            let is_help = !error.use_stderr();
            terminal::print_usage(&error);
            return ExitCode::from(u8::from(!is_help));
        }
    };
    // Pipelines with passes that a host fills can be looked at, and an error states that nobody fills them here.
    let host = host_kinds(tables);
    let known = [tables, &[&host]].concat();
    let result = match &arguments.command {
        Command::Demo(args) => demo::run(args, tables),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args, tables),
        Command::Render(args) => watch::run(args, &known),
        Command::Check(args) => check::run(args, &known),
        Command::Plan(args) => plan::run(args, &known),
        Command::Nodes(args) => nodes::run(args, &known),
        Command::Measure(args) => measure::run(args, tables),
        Command::Tune(args) => tune::run(args, tables),
        Command::Bench(args) => bench::run(args, tables),
        Command::Stress(args) => stress::run(args, tables),
    };
    match result.and_then(|()| Ok(terminal::check_output()?)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
