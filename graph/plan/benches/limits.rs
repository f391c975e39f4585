//! Seconds and memory of the worst pipelines: `cargo bench -p afterimage-plan --bench limits [-- BOMB [SIZE]]`.
//!
//! Each bomb is made at the sizes of the table, parsed, checked and planned, each in a process of its own. `MB` is the
//! most memory that the process had. A bomb beyond a limit ends with the code of the limit's error.
#![allow(clippy::print_stdout, missing_docs, reason = "a benchmark prints, and exports nothing")]

use std::process::Command;
use std::time::Instant;

use afterimage_generators::{BOMBS, Bomb, MakeBomb};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, PlanRequest, Requirement, plan};

const SIZES: [usize; 3] = [1000, 4000, 10_000];
const FRAME: Size = Size { width: 3840, height: 2160, depth: 1 };

fn main() {
    // Cargo passes `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let size = |word: &String| word.parse().unwrap_or_else(|_| panic!("{word} is no size"));
    match words.as_slice() {
        [name, sizes @ ..] if !sizes.is_empty() => run(name, size(&sizes[0])),
        names => table(names.first().map(String::as_str)),
    }
}

fn table(only: Option<&str>) {
    println!("{:24} {:>6} {:>7} {:>7} {:>7} {:>7} {:>6}", "bomb", "size", "kB", "nodes", "check s", "plan s", "MB");
    let program = std::env::current_exe().expect("a process has a program");
    for (name, _) in BOMBS.iter().filter(|(name, _)| only.is_none_or(|only| only == *name)) {
        for size in SIZES {
            let child = Command::new(&program).args([name, size.to_string().as_str()]).status();
            assert!(child.expect("the program starts").success(), "{name} {size} failed");
        }
    }
}

fn run(name: &str, size: usize) {
    let (_, make): &(&str, MakeBomb) = BOMBS.iter().find(|(known, _)| *known == name).expect("a name of a bomb");
    let bomb = make(size);
    let bytes = bomb.text.len() + bomb.files.values().map(String::len).sum::<usize>();
    let start = Instant::now();
    let checked = checked(&bomb);
    let check_time = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let (nodes, outcome) = match &checked {
        Ok(graph) => (graph.nodes.len(), planned(graph)),
        Err(code) => (0, (*code).to_owned()),
    };
    let (plan_time, peak) = (start.elapsed().as_secs_f64(), peak_megabytes());
    let kilobytes = bytes / 1000;
    println!("{name:24} {size:6} {kilobytes:7} {nodes:7} {check_time:7.2} {plan_time:7.2} {peak:>6} {outcome}");
}

fn checked(bomb: &Bomb) -> Result<Graph, &'static str> {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader: bomb, ..CheckOptions::default() };
    let graph = parse("bomb.ron", &bomb.text).and_then(|document| check(&document, &registry, &options));
    graph.map(|(graph, _)| graph).map_err(|errors| code(&errors))
}

/// The code of the first error that names a limit, or of the first error.
fn code(errors: &Diagnostics) -> &'static str {
    let codes = || errors.iter().map(|error| error.code);
    codes().find(|code| code.starts_with("too-") || code.starts_with("long-")).or(codes().next()).unwrap_or_default()
}

/// Plans; the number of passes, or the error.
fn planned(graph: &Graph) -> String {
    let given = HostImageDesc { desc: ImageDesc::new(FRAME), finite: false };
    let request = PlanRequest {
        given: HostInputs {
            inputs: graph.inputs.iter().map(|input| (input.name.clone(), given)).collect(),
            ..HostInputs::none(FRAME)
        },
        facts: Facts::default(),
        caps: Caps { storage: Format::ALL.into(), fast_workgroup_memory: true, ..Caps::default() },
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    plan(graph, &request).map_or_else(|error| error.to_string(), |plan| format!("{} passes", plan.passes.len()))
}

/// The most memory that the process has had, as Linux reports it.
fn peak_megabytes() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    kilobytes.map_or_else(|| "-".to_owned(), |kilobytes| (kilobytes / 1000).to_string())
}
