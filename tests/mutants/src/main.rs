//! Mutants of the pure crates, and whether a test notices them: `tests/mutants.sh`.
//!
//! The mutants are those of `cargo mutants --list`. All of a sample are compiled at once, each behind a condition on
//! its number, and each test is run once to see which of them it reaches. A mutant then costs only the tests that reach
//! it, and no compilation.
#![allow(clippy::print_stdout, reason = "a tool for the command line")]

mod build;
mod list;
mod report;
mod run;
mod sites;
mod weave;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use build::{PURE, Program, Tree};
use list::Mutant;
use report::Report;
use run::{Test, on_all_cores, outcome, summary, traced};

/// The seed of the order of mutants.
const SEED: u64 = 17;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let here = std::env::current_dir().expect("there is a folder");
    let folder = here.join("target/mutants/sample");
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["sample", from, count] => {
            weave(&folder, number(from), number(count));
            run_woven(&folder, from);
        }
        ["weave", from, count] => weave(&folder, number(from), number(count)),
        ["run", from] => run_woven(&folder, from),
        _ => panic!("`sample|weave FIRST COUNT`, or `run FIRST`"),
    }
}

fn number(word: &str) -> usize {
    word.parse().unwrap_or_else(|error| panic!("`{word}`: {error}"))
}

/// A sample that is compiled. With the programs and the copy of the source at the same places,
/// another machine can run it.
#[derive(Serialize, Deserialize)]
struct Woven {
    sample: Vec<Mutant>,
    refused: BTreeSet<usize>,
    programs: Vec<Program>,
}

/// Compiles a sample of the mutants of the pure crates.
fn weave(folder: &Path, from: usize, count: usize) {
    let packages = PURE.map(|(name, _)| name);
    let all = list::shuffled(&packages, SEED);
    let sample: Vec<Mutant> = all.iter().skip(from).take(count).cloned().collect();
    println!("{} of {} mutants, from {from} on", sample.len(), all.len());
    let tree = Tree::copy(folder);
    let refused = tree.weave(&sample);
    Woven { refused, programs: tree.programs(), sample }.write(folder, &from.to_string());
}

impl Woven {
    fn write(&self, folder: &Path, name: &str) {
        let text = serde_json::to_string(self).expect("it is made of texts and numbers");
        std::fs::write(woven_file(folder, name), text).expect("the folder can be written to");
    }
}

fn woven_file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("woven-{name}.json"))
}

/// Runs the tests with each mutant of a sample that is compiled.
fn run_woven(folder: &Path, name: &str) {
    let text = std::fs::read_to_string(woven_file(folder, name)).expect("it is compiled");
    let Woven { sample, refused, programs } = serde_json::from_str(&text).expect("it is a sample");
    let tests = traced(&programs, folder);
    let results = folder.join(format!("results-{name}.tsv"));
    run(&sample, &refused, &tests, &results);
    print!("{}", Report::read(&results, &sample));
}

/// Runs the mutants that the table of results does not have yet, several at a time.
fn run(mutants: &[Mutant], refused: &BTreeSet<usize>, tests: &[Test], results: &Path) {
    print!("{}", summary(tests));
    let known = std::fs::read_to_string(results).unwrap_or_default();
    let is_new = |mutant: &Mutant| !known.lines().any(|line| line.split('\t').next() == Some(&mutant.name));
    let open: Vec<usize> = (0..mutants.len()).filter(|number| is_new(&mutants[*number])).collect();
    let known = Mutex::new(known);
    on_all_cores(open.len(), |at| {
        let (number, mutant) = (open[at], &mutants[open[at]]);
        let outcome = match refused.contains(&number) {
            true => "refused".to_owned(),
            false => outcome(number, &mutant.package, tests),
        };
        println!("{number} {}\t{outcome}", mutant.name);
        let mut known = known.lock().expect("no thread panics with it");
        writeln!(known, "{}\t{outcome}", mutant.name).expect("a string grows");
        std::fs::write(results, &*known).expect("the folder can be written to");
    });
}
