//! `cargo run --release -p afterimage-bench -- kinds`, `lynx` or `growth`: times that developers of the framework compare.
//!
//! - `kinds`: each built-in kind on its own, compared with the copy bandwidth of the device and with the same work
//!   written by hand.
//! - `lynx`: the pipeline `lynx.ron` next to the same chain written by hand.
//! - `compile`: the seconds that a driver compiles each built-in kind and pipeline, as comma-separated values. Set
//!   `MESA_SHADER_CACHE_DISABLE=true`.
//! - `growth`: time and memory by the number of pixels and of nodes, as comma-separated values.

mod baselines;
mod growth;
mod kinds;
mod raw;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use afterimage::offline::{Session, timing};
use afterimage_gpu::{Clock, Gpu, Opening};
use afterimage_graph::check::{CheckOptions, Facts, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_lab::{LabError, scene, stress};
use afterimage_media::write_atomic;
use afterimage_pipelines::PIPELINES;
use afterimage_plan::Options;
use baselines::lynx::{self, BaselineReport};
use clap::{Parser, Subcommand};
use kinds::KindsReport;
use serde::Serialize;

#[derive(Parser)]
#[command(name = "afterimage-bench")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Samples of each median
    #[arg(long, global = true, default_value_t = 30)]
    frames: u32,
    /// Pixels of a frame, of `kinds` and `lynx`; can be repeated for `kinds`
    #[arg(long, global = true, value_name = "WxH", value_parser = parse_size)]
    size: Vec<Size>,
    /// Also write the figures of `kinds` and `lynx` as JSON
    #[arg(long, global = true, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Command {
    /// Each built-in kind on its own
    Kinds {
        /// Only these kinds
        kinds: Vec<String>,
    },
    /// The pipeline `lynx.ron` next to the same chain written by hand
    Lynx,
    /// Seconds to compile each built-in kind and pipeline
    Compile,
    /// Time and memory by the number of pixels and of nodes
    Growth,
}

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "this is a program")]
fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(mut args: Arguments) -> Result<String, LabError> {
    let gpu = Gpu::open(&Opening::default())?;
    if args.size.is_empty() {
        args.size = vec![Size::new(1920, 1080)];
    }
    match &args.command {
        Command::Kinds { kinds } => {
            let report = named_kinds(&gpu, kinds, &args.size, args.frames)?;
            write_json(&args, &report)?;
            Ok(report.to_string())
        }
        Command::Lynx => {
            let report = lynx_report(&gpu, args.size[0], args.frames)?;
            write_json(&args, &report)?;
            Ok(json(&report))
        }
        Command::Compile => compile(&gpu),
        Command::Growth => growth::growth(&gpu, &stress_registry(), args.frames),
    }
}

fn json(report: &impl Serialize) -> String {
    serde_json::to_string_pretty(report).expect("names and finite numbers are JSON")
}

fn write_json(args: &Arguments, report: &impl Serialize) -> Result<(), LabError> {
    match &args.json {
        Some(file) => Ok(write_atomic(file, json(report).as_bytes())?),
        None => Ok(()),
    }
}

/// The built-in kinds, and those that make values and tables visible.
fn stress_registry() -> Arc<Registry> {
    stress::registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name")
}

/// The kinds of these names on their own; all without names.
fn named_kinds(gpu: &Gpu, names: &[String], sizes: &[Size], samples: u32) -> Result<KindsReport, LabError> {
    let registry = stress_registry();
    let mut tables: Vec<&[NodeKind]> = Vec::new();
    for name in names {
        let kind = registry.get(name).ok_or_else(|| LabError::request(format!("no node kind is called `{name}`")))?;
        tables.push(std::slice::from_ref(kind));
    }
    if names.is_empty() {
        tables.push(afterimage_nodes::ALL);
    }
    kinds::kinds(gpu, &registry, &tables, sizes, samples)
}

fn compile(gpu: &Gpu) -> Result<String, LabError> {
    let (registry, size) = (stress_registry(), Size::new(64, 36));
    let mut text = "name,operations of a pass,of all passes,seconds\n".to_owned();
    text += &kinds::compile(gpu, &registry, &[afterimage_nodes::ALL], size)?;
    for (name, pipeline) in PIPELINES {
        let line = compile_pipeline(gpu, &registry, size, name, pipeline);
        text += &line.unwrap_or_else(|error| format!("{name}: {error}\n"));
    }
    Ok(text)
}

fn compile_pipeline(gpu: &Gpu, registry: &Registry, size: Size, name: &str, text: &str) -> Result<String, LabError> {
    let graph = scene::graph(registry, name, text)?;
    let images = scene::still(gpu, registry, &graph, size)?;
    let start = Instant::now();
    let mut session = Session::new(gpu, graph, Facts::default(), Options::default());
    session.load(size, &images)?;
    kinds::compiled(&mut session, &images, name, start)
}

/// The time of a frame of `lynx.ron`, and of the chains written by hand.
#[derive(Debug, Serialize)]
struct LynxReport {
    gpu_ms: f64,
    baseline: BaselineReport,
}

fn lynx_report(gpu: &Gpu, size: Size, samples: u32) -> Result<LynxReport, LabError> {
    let registry = stress_registry();
    let (_, text) = PIPELINES.iter().find(|(name, _)| *name == "lynx").expect("a built-in pipeline");
    // The chains have the curve as published.
    let overrides = [
        ("mapped.space", "Rec709"),
        ("mapped.middle_gray", "Native"),
        ("mapped.keep_hue", "0.0"),
        ("mapped.gamut", "Clip"),
    ];
    let sets = overrides.map(|(name, value)| (name.to_owned(), value.to_owned())).into();
    let (graph, _) = check(&parse("lynx.ron", text)?, &registry, &CheckOptions { sets, ..CheckOptions::default() })?;
    let images = scene::still(gpu, &registry, &graph, size)?;
    let chain = lynx::Chain::of(&graph).expect("the chains implement `lynx.ron`");
    let chains = lynx::chains(gpu, &chain, &images[0].view);
    let mut session = Session::new(gpu, graph, Facts::default(), Options::default());
    session.load(size, &images)?;
    let clock = Clock::new(gpu)?;
    let (frame, times) = timing::frame_time(&mut session, &clock, samples, &images, lynx::recordings(&chains))?;
    let output = session.plan().outputs[0].name.clone();
    let picture = session.output(&output)?.to_floats();
    Ok(LynxReport { gpu_ms: frame.ms(), baseline: lynx::report(gpu, &chains, &times, &picture)? })
}

fn parse_size(text: &str) -> Result<Size, String> {
    let parts = text.split_once('x').and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    match parts {
        Some((width @ 1.., height @ 1..)) => Ok(Size::new(width, height)),
        _ => Err("a size is two whole numbers from 1, such as 1920x1080".into()),
    }
}

#[cfg(test)]
mod tests;
