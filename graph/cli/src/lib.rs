//! The program `afterimage` as a library: the program of a plug-in author calls [`main()`] with one more table of
//! kinds.
//!
//! Features: `view`, on by default, has the command of that name, with a window; `ocio` has `--ocio` and the kind
//! `OcioTransform`; `avif` and `jxl` read AVIF and JPEG XL.
// rustdoc asks whether types that hold a GPU are `Sync`, which goes through more than 128 types of wgpu.
#![recursion_limit = "256"]

mod advice;
mod args;
mod bench;
mod built_in;
mod cameras;
mod check;
mod demo;
mod device;
mod explain;
mod failure;
mod files;
mod frame_ranges;
mod info;
mod job;
mod lut;
mod measure;
mod nodes;
#[cfg(feature = "ocio")]
mod ocio;
mod pipeline;
mod pipelines;
mod plan;
mod process;
mod progress;
mod render;
mod save;
mod scaffold;
mod stress;
mod terminal;
mod tier_file;
mod tune;
#[cfg(feature = "view")]
mod view;
mod watch;

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use afterimage_graph::diagnostic::shown_path;
use afterimage_graph::node::NodeKind;
use afterimage_media::write_atomic;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory as _, FromArgMatches as _};

use args::{Arguments, Command, JobArgs};
use failure::Failure;
use process::Again;

/// Runs the program with the kinds of these tables and the arguments of the process.
pub fn main(tables: &[&[NodeKind]]) -> ExitCode {
    process::prepare();
    run_words(tables, std::env::args_os(), Again::of_this_process().as_ref())
}

/// The script that completes the words of the program in a shell.
fn completions(shell: clap_complete::Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "afterimage", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// The definition of the command line, for those who describe or test it.
pub fn command() -> clap::Command {
    args::command()
}

/// The arguments of the command line and of the variables `AFTERIMAGE_*`.
fn parse(words: impl IntoIterator<Item = OsString>) -> Result<(Arguments, ArgMatches), clap::Error> {
    let matches = command().try_get_matches_from(words).map_err(advice::advised)?;
    let mut arguments = Arguments::from_arg_matches(&matches)?;
    if let Command::Render(args) | Command::Job(JobArgs { render: args, .. }) = &mut arguments.command {
        let source = matches.subcommand().and_then(|(_, matches)| matches.value_source("output_space"));
        args.exr.is_space_of_all_runs = source == Some(ValueSource::EnvVariable);
    }
    Ok((arguments, matches))
}

/// Writes the manual pages of the program and of its commands.
fn manual(folder: &Path) -> Result<(), Failure> {
    let unwritable = |error: std::io::Error| Failure::machine(format!("{}: {error}", shown_path(folder)));
    std::fs::create_dir_all(folder).map_err(unwritable)?;
    let mut program = Arguments::command().disable_help_subcommand(true);
    program.build();
    let commands: Vec<clap::Command> = program.get_subcommands().cloned().collect();
    for command in [program].into_iter().chain(commands) {
        let page = clap_mangen::Man::new(command);
        let mut text = Vec::new();
        page.render(&mut text).map_err(unwritable)?;
        write_atomic(&folder.join(page.get_filename()), &text)?;
    }
    Ok(())
}

/// The kinds whose passes a host fills, without those whose names the tables have.
fn host_kinds(tables: &[&[NodeKind]]) -> Vec<NodeKind> {
    let is_new = |kind: &&NodeKind| tables.iter().copied().flatten().all(|known| known.name() != kind.name());
    afterimage_nodes::HOST.iter().filter(is_new).cloned().collect()
}

/// Runs the program with the kinds of these tables and these arguments, the first of which is the program's name. It
/// starts no further process of itself.
pub fn run(tables: &[&[NodeKind]], arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    run_words(tables, arguments, None)
}

/// Runs the program; `again` is how to start it in processes of its own, if it may.
fn run_words(tables: &[&[NodeKind]], arguments: impl IntoIterator<Item = OsString>, again: Option<&Again>) -> ExitCode {
    let (mut arguments, matches) = match parse(arguments) {
        Ok(parsed) => parsed,
        Err(error) => {
            let is_help = !error.use_stderr();
            terminal::print_usage(error);
            return ExitCode::from(u8::from(!is_help));
        }
    };
    if let Some(folder) = &arguments.folder
        && let Err(error) = std::env::set_current_dir(folder)
    {
        return Failure::user(format!("-C {}: {error}", shown_path(folder))).report();
    }
    match &mut arguments.command {
        Command::Render(args) | Command::Job(JobArgs { render: args, .. }) => args.put_in_order(),
        #[cfg(feature = "view")]
        Command::View(args) => view::put_in_order(args),
        _ => {}
    }
    files::begin_run();
    #[cfg(feature = "ocio")]
    if let Some(config) = &arguments.ocio
        && let Err(failure) = ocio::choose(config)
    {
        return failure.report();
    }
    #[cfg(feature = "ocio")]
    let tables = &*[tables, &[ocio::KINDS]].concat();
    // Pipelines with passes that a host fills can be looked at, and an error states that nobody fills them here.
    let host = host_kinds(tables);
    let known = [tables, &[&host]].concat();
    let computes = match &arguments.command {
        Command::Render(_) | Command::Meter(_) | Command::Info(_) | Command::Demo(_) => true,
        Command::Measure(_) | Command::Tune(_) | Command::Bench(_) | Command::Stress(_) | Command::Lut(_) => true,
        #[cfg(feature = "view")]
        Command::View(_) => true,
        _ => false,
    };
    if computes && let Err(failure) = process::start_threads() {
        return failure.report();
    }
    let result = match &arguments.command {
        Command::Demo(args) => demo::run(args, tables),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args, tables),
        Command::Render(args) => watch::run(args, &known),
        Command::Meter(args) => render::meter(args, &known),
        Command::Job(args) => job::run(args, matches.subcommand_matches("job").expect("it is the command"), &known),
        Command::Info(args) => info::run(args),
        Command::Check(args) => check::run(args, &known),
        Command::Explain(args) => explain::run(args),
        Command::Plan(args) => plan::run(args, &known),
        Command::Lut(args) => lut::run(args, tables),
        Command::New(args) => pipelines::new(&args.file),
        Command::Nodes(args) => nodes::run(args, &known),
        Command::Pipelines(args) => pipelines::run(args, tables),
        Command::Measure(args) => measure::run(args, tables),
        Command::Tune(args) => tune::run(args, tables),
        Command::Bench(args) => bench::run(args, tables),
        Command::Stress(args) => stress::run(args, tables, again),
        Command::Man(args) => manual(&args.folder),
        Command::Completions(args) => {
            terminal::say_text(&completions(args.shell));
            Ok(())
        }
    };
    match result.and_then(|()| Ok(terminal::check_output()?)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
